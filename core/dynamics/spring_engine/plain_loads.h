// What loads and holds a body on the plain path: supports, pads, loads that change with time, prescribed
// motions, and the forces of all of these on the body, step by step.
#pragma once

#include <span>
#include <vector>

#include "core/dynamics/motion/motion_model.h"

namespace palpate::dynamics {

/// Where an engine keeps its vertices: order[k] is the vertex that comes k-th, place its inverse, blocks of
/// `block_vertices`, positions from `center`, or each from its own place in the rest shape.
struct PlainPlaces {
  std::span<const Index> order;
  std::span<const Index> place;
  std::size_t block_vertices = 0;
  Vec3 center;
  bool from_rest = false;  ///< positions are displacements

  /// What a displacement of zero is as a position.
  Vec3 home(const Vec3& rest) const { return from_rest ? Vec3{} : rest - center; }
};

/// The first number of the first vertex, and how many numbers lie between two vertices.
template <typename Real>
struct PlainRows {
  Real* first = nullptr;
  std::size_t stride = 0;
  Real* of(std::size_t k) const { return first + k * stride; }
};

/// Acts on the listed vertices alone, block by block, in double precision whatever the engine's. Blocks don't
/// touch each other's vertices, and sums over blocks are taken in their order: the bits don't depend on the
/// number of threads.
class PlainLoads {
 public:
  /// Requires: a valid model.
  PlainLoads(const MotionModel& model, const PlainPlaces& places);

  /// Dead loads that never change on the vertex at place k, in N. They are not among those of add_forces.
  const Vec3& steady_force(std::size_t k) const { return steady_[k]; }
  /// Whether the vertex at place k is held in all directions.
  bool is_held(std::size_t k) const { return is_held_[k] != 0; }

  /// Before a step from `time_s` to `end_s`; not while blocks are at work.
  void set_times(double time_s, double end_s);

  /// Adds the forces on the vertices of block b at the step's start, for positions `x` of all vertices, to
  /// `force`, four numbers a vertex of the block; notes what holds and loads them. Held components take the
  /// whole force: call it after the springs have added theirs.
  template <typename Real>
  void add_forces(std::size_t b, const PlainRows<const Real>& x, Real* force);

  /// Puts held components of block b where the profiles have them at the step's end.
  template <typename Real>
  void hold(std::size_t b, const PlainRows<Real>& x, const PlainRows<Real>& v) const;

  /// Puts all held components where the profiles have them at `time_s`.
  template <typename Real>
  void hold_all(double time_s, const PlainRows<Real>& x, const PlainRows<Real>& v) const;

  /// Adds up what the blocks have noted; not while they are at work.
  void gather();

  /// Puts an elastic pad on `faces` in the place of the one before, at rest; no faces: takes it away. Its
  /// forces are added behind those of the groups. Not while blocks are at work. SupportFace::by_m is not
  /// read: move_pad says where the pad is. Shape: `rest` one point a vertex.
  void set_pad(std::span<const SupportFace> faces, const PlainPlaces& places, std::span<const Vec3> rest);

  /// Moves the pad to `by_m`, from where it was put.
  void move_pad(const Vec3& by_m) { pad_by_m_ = by_m; }

  /// The pad's force on the body at the start of the last step that was gathered, in N.
  const Vec3& pad_force() const { return pad_force_n_; }

  /// As MotionForces::group_forces, at the start of the last step that was gathered: the force of each group
  /// of loads on the body, in N. Zero before the first.
  const std::vector<Vec3>& group_forces() const { return group_forces_; }

 private:
  /// A vertex that a group loads: share x load + pull - sum of coefficient x position.
  struct Row {
    Index at = 0;  ///< place, from the block's first
    std::uint32_t group = 0;
    Vec3 load;
    Vec3 pull;
    std::size_t first = 0;
    std::size_t last = 0;
  };
  struct Entry {
    Index place = 0;
    double coefficient_n_per_m = 0.0;
  };
  struct Held {
    Index at = 0;
    std::uint8_t axis = 0;
    std::uint32_t group = 0;
    double rest_m = 0.0;
    double by_m = 0.0;
    double mass_kg = 0.0;
    double drag_n_s_per_m = 0.0;
  };
  /// A vertex under the pad: total x by + pull - sum of coefficient x position.
  struct PadRow {
    Index at = 0;
    double total_n_per_m = 0.0;
    Vec3 pull;
    std::size_t first = 0;
    std::size_t last = 0;
  };
  struct Block {
    std::size_t first = 0;
    std::vector<Row> rows;
    std::vector<Held> held;
    std::vector<Vec3> forces;  ///< of each group on the block
    std::vector<PadRow> pad;
    Vec3 pad_force;
  };

  template <typename Real>
  void press_pad(Block& block, const PlainRows<const Real>& x, Real* force) const;

  void add_rows(const TimedLoads& group, std::uint32_t number, bool is_steady, const MotionModel& model,
                const PlainPlaces& places);
  void add_held(const MotionModel& model, const PlainPlaces& places);

  std::vector<TimeProfile> profiles_;
  std::vector<Vec3> steady_;
  std::vector<Vec3> steady_sum_;  ///< of each group
  std::vector<char> is_held_;
  std::vector<Block> blocks_;
  std::vector<Entry> entries_;
  std::vector<ProfileValue> start_;
  std::vector<ProfileValue> end_;
  std::vector<Vec3> group_forces_;
  std::vector<Entry> pad_entries_;
  Vec3 pad_by_m_;
  Vec3 pad_force_n_;
};

}  // namespace palpate::dynamics

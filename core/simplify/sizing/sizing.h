// Regions of a mesh that a scene needs in full, how far sizes may grow away from them, and wanted sizes.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "core/mesh/tet_mesh.h"
#include "core/simplify/sizing/size_grid.h"
#include "core/simplify/sizing/triangle_tree.h"

namespace palpate::simplify {

/// A part of space whose tets are left alone. Lengths in the mesh's own unit.
struct KeptRegion {
  enum class Kind {
    kSphere,       ///< |x - center| <= radius
    kHalfSpace,    ///< normal . x <= offset: the normal points out of what is kept
    kSurfacePatch  ///< within `depth` of the boundary faces that have a vertex with |v - center| <= radius
  };
  Kind kind = Kind::kSphere;
  Vec3 center{};
  double radius = 0.0;
  Vec3 normal{};  ///< of any length but 0; a multiple of normal and offset is the same half-space
  double offset = 0.0;
  double depth = 0.0;
};

/// What to keep, how sizes grade from there, and the sizes that are wanted anyway.
struct SizingOptions {
  std::vector<KeptRegion> keep;
  double near_size = 0.5;  ///< relative size at a region's border, in (0, 1]
  double reach =
      0.0;  ///< distance at which the relative size is 1; 0: a quarter of the bounding box's diagonal
  std::shared_ptr<const SizeGrid> sizes = nullptr;  ///< wanted everywhere (make_size_grid); null: one size
};

/// The wanted edge length over that of the far field, and the distance to what is kept.
///
/// Cost: a few operations for spheres and half-spaces, about the logarithm of its number of faces for a
/// patch. The field holds no reference to the mesh that it was made for. Safe to ask from several threads.
class SizingField {
 public:
  /// An empty field: keeps nothing, relative size 1 everywhere.
  SizingField() = default;
  /// Throws: InputError for a radius, normal, near_size or reach that makes no sense, or a patch that no
  /// boundary vertex lies in.
  SizingField(const SizingOptions& options, const TetMesh& mesh);

  bool is_empty() const { return regions_.empty() && sizes_ == nullptr; }
  bool keeps_any() const { return !regions_.empty(); }
  bool has_sizes() const { return sizes_ != nullptr; }
  double near_size() const { return near_size_; }  ///< the least relative size; 1 for an empty field
  double reach() const { return reach_; }          ///< where relative sizes become 1; 0 for an empty field

  /// Distance from x to the nearest region; 0 inside. Infinite without regions. Lipschitz with constant 1.
  double distance(const Vec3& x) const;

  /// The relative size at x, in (0, 1]: near_size at a region, 1 from `reach` on.
  ///
  ///   near_size + (1 - near_size) (3 t^2 - 2 t^3),   t = min(1, distance / reach)
  ///
  /// Without a step or a kink at t = 0 and t = 1; between regions there may be a kink where the nearest one
  /// changes. Lipschitz with the constant 1.5 (1 - near_size) / reach. With sizes that are wanted anyway the
  /// less of both.
  double relative_size(const Vec3& x) const;

  /// Does a tet of the mesh meet a region? Without a margin: the least distance over the whole tet, not over
  /// its vertices alone, is held against radius, offset and depth; what only touches, meets. Requires, for a
  /// patch: the tet has no inner point in common with the boundary.
  bool meets(const std::array<Vec3, 4>& tet) const;

 private:
  struct Region {
    KeptRegion shape;     ///< its normal is of unit length
    std::size_t patch{};  ///< number of its tree, for a patch
  };
  double distance_to(const Region& region, const Vec3& x, double bound) const;

  std::vector<Region> regions_;
  std::vector<TriangleTree> patches_;
  std::shared_ptr<const SizeGrid> sizes_;
  double region_size_ = 1.0;  ///< relative size at a region
  double near_size_ = 1.0;
  double reach_ = 0.0;
};

/// The integral of 1 / relative size^3 over the mesh: its volume, counted by the room that a tet gets.
double graded_volume(const TetMesh& mesh, const SizingField& field);

/// Passes with a bound on growth, before the last one without.
inline constexpr int kGradingPasses = 8;

/// How fusions grade a mesh: in pass n = 0, 1, ... only tets smaller than their place allows are fused,
///
///   volume < r^3 2^n mean volume,   r = the relative size at the tet's barycenter,
///
/// so that a tet near a region waits until the far ones have become as much larger as the field asks for.
class GrowthBound {
 public:
  /// `mean_volume` is that of the input's tets. The field has to outlive the bound.
  GrowthBound(const SizingField& field, double mean_volume) : field_(&field), mean_volume_(mean_volume) {}

  /// Passes with a bound: none if every relative size is 1.
  int passes() const { return field_->near_size() < 1.0 ? kGradingPasses : 0; }

  /// Begins pass n; from pass passes() on every tet may grow.
  void start_pass(int n);

  /// May the positive tet with these corners grow in this pass?
  bool admits(const std::array<Vec3, 4>& tet) const;

 private:
  const SizingField* field_;
  double mean_volume_;
  double largest_far_ = std::numeric_limits<double>::infinity();  ///< volume allowed where r = 1
};

/// One flag a tet: 1 if it meets a region. Such a tet is in the output as it was, to the bit. Empty for an
/// empty field.
std::vector<std::uint8_t> build_kept_tets(const SizingField& field, const TetMesh& mesh);

/// One flag a vertex: 1 if a kept tet has it. Such a vertex is neither moved nor removed. Empty for no flags.
std::vector<std::uint8_t> build_kept_vertices(const std::vector<std::uint8_t>& kept_tets,
                                              const TetMesh& mesh);

}  // namespace palpate::simplify

// The longest stable time step of explicit schemes: which vertices hold it down, and operations that let go
// of them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/simplify/refined/vertex_rate.h"
#include "core/simplify/tet_operations/flips.h"
#include "core/simplify/tet_operations/working_mesh.h"

namespace palpate::simplify {

/// What a mesh is to be good for.
enum class Objective : std::uint8_t {
  kShape,      ///< scores by the mean ratio: all measures of shape, and the error of linear elements
  kQuality,    ///< scores by solid angles: the thesis's quality
  kStableStep  ///< the method's default first, then the longest stable step of explicit schemes
};

/// Rounds of StepLengthener::run at the end of a run with kStableStep; most end before.
inline constexpr int kStepRounds = 10;

/// How often each operation was made.
struct StepCounts {
  std::uint64_t moves = 0;
  std::uint64_t edges_removed = 0;
  std::uint64_t faces_removed = 0;
};

/// What a StepLengthener asks of a skin whose vertices may move.
class SkinMoves {
 public:
  SkinMoves() = default;
  SkinMoves(const SkinMoves&) = delete;
  SkinMoves& operator=(const SkinMoves&) = delete;
  virtual ~SkinMoves() = default;
  virtual bool may_move(Index v) const = 0;
  /// The normal of the skin at v, of any length: v moves within the plane.
  virtual Vec3 normal_at(Index v) const = 0;
  /// Whether the skin permits v to be there; then the skin has it there, and the caller moves it in the mesh.
  virtual bool take_move(Index v, const Vec3& to) = 0;
};

/// Makes the longest stable step of a mesh longer: sees to the vertices with the greatest rates, one after
/// another, by moves of free vertices around them and by flips.
///
/// A change is made if the greatest rate among the vertices that it touches falls by half a percent at least,
/// no tet is left with a score below both the worst that was there and a guard (0.08; by solid angles q 0.43,
/// 23.6 degrees), and every tet stays positive, exactly. So the greatest rate of the mesh never rises.
/// Boundary faces and kept tets stay as they are, and boundary vertices where they are unless a skin permits
/// moves. Time: a star's gradients a trial; on organs up to 30 times that of simplify_refined.
class StepLengthener {
 public:
  /// Holds references to the mesh, the score rule and the skin, if one is given: without, the skin stays.
  StepLengthener(WorkingMesh& mesh, const ScoreRule& scores, const FlipRule& window,
                 SkinMoves* skin = nullptr);
  StepLengthener(const StepLengthener&) = delete;
  StepLengthener& operator=(const StepLengthener&) = delete;

  /// Rounds over the vertices whose rate is within a fifth of the greatest, until a round changes nothing;
  /// `rounds` at most.
  void run(int rounds);

  const StepCounts& counts() const { return counts_; }

 private:
  using StarTet = std::array<std::size_t, 3>;  ///< places in link_

  /// A place of the vertex that moves: the sum of the powers of the rates around, and the greatest.
  struct Place {
    Vec3 at;
    double powers = 0.0;
    double most = 0.0;
  };

  bool round();
  void renew(Index v);
  double greatest(const std::vector<Index>& vertices) const;
  bool improve(Index v);
  bool try_moves(Index v);
  bool try_move(Index v);
  bool try_skin_move(Index v);
  void take_star(Index v);
  Place look_at(const Vec3& place);
  Place descend(const Vec3& from, double edge, const Vec3& normal = {});
  void settle(Index v);
  void put(Index v, const Vec3& place);
  bool try_flips(Index v, bool with_moves);
  double take_flip();
  bool keep_flip();
  bool keep_flip_with_moves();
  void collect_link(Index v, std::vector<Index>& out) const;

  WorkingMesh& mesh_;
  ScoreRule scores_;
  Flipper trial_;    ///< makes any flip
  SkinMoves* skin_;  ///< null: the skin stays
  StepCounts counts_;
  std::vector<VertexRate> known_;  ///< one a vertex
  std::vector<double> rates_;      ///< theirs
  StarQuality star_;
  double reference_ = 1.0;
  std::size_t tries_left_ = 0;
  std::vector<Index> link_;       ///< of the vertex that moves, sorted
  std::vector<VertexRate> rest_;  ///< of link_, without the tets of that vertex
  std::vector<VertexRate> sums_;  ///< of link_, with the vertex at a place
  std::vector<StarTet> star_tets_;
  std::vector<Index> touched_;
};

}  // namespace palpate::simplify

// Random edge collapses guarded by quality: a baseline in the manner of Cutler, Dorsey and McMillan (SGP
// 2004).
#pragma once

#include <cstdint>
#include <string>

#include "core/mesh/tet_mesh.h"

namespace palpate::reference {

/// Where the vertex goes that two interior vertices become. With one end on the boundary it stays there.
enum class Placement {
  kMidpoint,  ///< of the edge
  kBest       ///< the midpoint or one of the ends, whichever leaves the better worst tet
};

struct EdgeCollapseOptions {
  std::uint64_t target_tets = 0;  ///< stop at the first state with at most so many; 0: at the limit
  std::uint64_t seed = 0;
  int candidates = 8;        ///< edges drawn for each collapse
  double first_guard = 0.6;  ///< quality that the worst tet keeps at first, unless it was worse before
  double last_guard = 0.2;   ///< how far the guard is lowered, kGuardStep at a time, when little passes it
  Placement placement = Placement::kBest;
};

inline constexpr double kGuardStep = 0.05;
inline constexpr double kWorthwhileRate = 0.01;  ///< collapses a draw; below it the guard is lowered

/// What was done; the counts of refused edges are of all that were drawn.
struct EdgeCollapseReport {
  std::uint64_t collapses = 0;
  std::uint64_t refused_boundary = 0;  ///< both ends on the boundary
  std::uint64_t refused_flip = 0;      ///< a tet would not stay positive, wherever the vertex goes
  std::uint64_t refused_quality = 0;   ///< the worst tet would be too bad
  bool reached_target = false;
};

/// Simplifies `mesh` in place by collapsing interior edges drawn at random.
///
/// Again and again a few edges are drawn (a random tet, a random edge of it); of those that may be collapsed
/// the one is collapsed that leaves the best worst tet. An edge may be collapsed if an end lies inside (a
/// boundary end stays where it is, so the boundary is kept), if all tets around stay positive (exact), and if
/// the worst of them is no worse than the guard, or than the worst before. Quality: cube root of (least solid
/// angle / 0.55 sr) (shortest / longest edge). After as many draws as there are tets, the guard is lowered if
/// fewer than one in a hundred ended in a collapse; under the last guard the run ends, at the limit, when
/// none did.
///
/// Of the paper this has random draws and collapses guarded by the shape of tets; its swaps, smoothing,
/// vertex additions and regions of several materials are left out.
///
/// Requires: a valid mesh. Throws: InputError for a non-manifold face.
EdgeCollapseReport collapse_random_edges(TetMesh& mesh, const EdgeCollapseOptions& options);

}  // namespace palpate::reference

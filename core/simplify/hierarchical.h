// The thesis's simplifier: worst tet first, from the innermost level outwards (thesis 2.3, 4.2.3).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/mesh/tet_mesh.h"
#include "core/simplify/fusion.h"
#include "core/simplify/levels.h"
#include "core/simplify/quality.h"
#include "core/simplify/sizing.h"

namespace palpate::simplify {

/// The ideal volume of the quality factor during a run.
enum class IdealVolume {
  kFixed,   ///< the input's mean tet volume
  kUpdated  ///< the mean volume of the tets that are left
};

/// When to stop, whichever comes first; without any, at the limit: when nothing more can be fused.
struct StopRule {
  std::optional<std::uint64_t> fusions;  ///< after so many fusions
  std::optional<std::uint64_t> tets;     ///< at the first state with at most so many tets
  std::optional<double> ratio;  ///< at the first state with this share of the tets removed, in [0, 1)
};

/// Which of the pre-checks of 4.2.3.5 are made. Without them the result need not be a valid mesh.
struct FusionChecks {
  bool flip = true;     ///< check 4: every moved tet stays positive (exact; flat counts as flipped)
  bool quality = true;  ///< check 3: every moved tet keeps at least `drop` of its former quality
};

struct SimplifyOptions {
  LevelAdjacency levels = LevelAdjacency::kVertex;
  double drop = 0.01;  ///< least share of its quality that a moved tet keeps, in [0, 1]; the thesis's 1/100
  IdealVolume ideal_volume = IdealVolume::kFixed;
  bool skip_touched = false;  ///< tets that a fusion moved are no candidates
  int last_level = 2;         ///< outermost level with candidates, at least 1; the thesis's 2 is check 2
  FusionChecks checks;
  QualityMetric metric = kThesisMetric;
  StopRule stop;
  SizingOptions sizing;  ///< what is kept, and how sizes grade from there; nothing by default
  StorageOrder storage = StorageOrder::kSpatial;
  int threads = 1;  ///< the result does not depend on it
};

/// The tets that are left, by the check that keeps each of them from being fused: as found when its level
/// ended or, at the level where a run stopped, when it was last looked at (those not looked at are not
/// counted).
struct Rejections {
  std::uint64_t boundary = 0;            ///< check 1: level 0
  std::uint64_t boundary_neighbour = 0;  ///< check 2: level 1 up to last_level - 1
  std::uint64_t quality = 0;             ///< check 3
  std::uint64_t flip = 0;                ///< check 4
  std::uint64_t touched = 0;             ///< with skip_touched
  std::uint64_t kept = 0;                ///< kept by the sizing field, or with a vertex of such a tet
};

struct SimplifyReport {
  std::uint64_t vertices_in = 0;
  std::uint64_t vertices_out = 0;
  std::uint64_t tets_in = 0;
  std::uint64_t tets_out = 0;
  std::uint64_t fusions = 0;
  std::string stop;  ///< "fusions", "tets", "ratio", or "limit" when nothing more could be fused
  Rejections rejected;
  std::vector<std::uint64_t> level_sizes;  ///< tets of each level in the input
};

/// Fewest tets that a run stopping by tets or ratio may still have to reach; 0 for neither.
std::uint64_t target_tet_count(const StopRule& stop, std::uint64_t tets_in);

/// The stop that a state of a run has reached, "fusions", "tets" or "ratio"; nullptr while there is none.
/// `target` is that of target_tet_count.
const char* reached_stop(const StopRule& stop, std::uint64_t target, std::uint64_t fusions,
                         std::uint64_t tets);

/// Throws: InputError for a ratio outside [0, 1), a drop outside [0, 1] and the like.
void validate_options(const SimplifyOptions& options);

/// Simplifies `mesh` in place.
///
/// For each level from the innermost to options.last_level: while it has a candidate that passes the checks,
/// the one of the lowest quality (ties: lowest number) is fused. Levels are not recomputed. Candidates wait
/// in a heap; one that fails a check is parked on the moved tet that failed it, its witness, and is looked at
/// again only when the witness or the candidate itself changes. That gives the same mesh, to the byte, as
/// scanning all candidates anew after each fusion. About k log n for k looks at candidates; at most 100 bytes
/// a tet with the mesh.
///
/// With regions to keep (options.sizing), a tet that has a vertex of a kept tet is never fused, so that kept
/// tets stay as they are, to the bit. Elsewhere tets grow as the field has it: the levels are gone through in
/// several passes under a rising bound (GrowthBound), the last time without one.
///
/// Requires: a valid mesh (positive tets, manifold faces).
/// Returns:  what was done. A mesh without a candidate is left as it is: stop "limit", 0 fusions.
/// Throws:   InputError for impossible options, or a non-manifold face.
/// Source:   thesis 2.3.3, 2.3.8, 4.2.3.5; docs/errata.md for what is settled otherwise.
SimplifyReport simplify_hierarchical(TetMesh& mesh, const SimplifyOptions& options);

}  // namespace palpate::simplify

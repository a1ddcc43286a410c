// Options and report of the simplifiers that fuse: the thesis's (hierarchical.h) and the one that
// fuses where it costs least (cheapest_first.h).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/simplify/fusion/fusion.h"
#include "core/simplify/fusion/levels.h"
#include "core/simplify/quality/quality.h"
#include "core/simplify/sizing/sizing.h"
#include "core/simplify/sizing/stop_rule.h"

namespace palpate::simplify {

/// The ideal volume of the quality factor during a run.
enum class IdealVolume {
  kFixed,   ///< the input's mean tet volume
  kUpdated  ///< the mean volume of the tets that are left
};

/// Which of the pre-checks of 4.2.3.5 are made. Without them the result need not be a valid mesh.
struct FusionChecks {
  bool flip = true;     ///< check 4: every moved tet stays positive (exact; flat counts as flipped)
  bool quality = true;  ///< check 3: every moved tet keeps at least `drop` of its former quality
};

/// How tets are fused: what may be, what is checked, and when it stops.
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

/// What was done.
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

/// Throws: InputError for a ratio outside [0, 1), a drop outside [0, 1] and the like.
void validate_options(const SimplifyOptions& options);

/// What a fusion is held to cost.
enum class CostObjective {
  kMovedLoss,  ///< quality that the moved tets lose
  kTotalLoss   ///< the same, and what the removed tets had above the mean quality of the input
};

/// How tets are fused where it costs least.
struct CheapestFirstOptions {
  CheapestFirstOptions() {
    common.drop = 0.5;
    common.last_level = 1;
    common.skip_touched = true;
  }
  /// As for the thesis's simplifier, with other defaults: drop 0.5; last_level 1, any tet without a boundary
  /// vertex; skip_touched. Both checks are always made, and the ideal volume is the input's.
  SimplifyOptions common;
  CostObjective objective = CostObjective::kMovedLoss;
  /// With skip_touched: when no candidate is left, the marks of touched tets are cleared and it goes on,
  /// until that finds none either.
  bool many_passes = true;
};

}  // namespace palpate::simplify

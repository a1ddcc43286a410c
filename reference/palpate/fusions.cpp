// The methods that fuse tets: palpate.hierarchical and palpate.outcome.
#include "core/simplify/fusion/cheapest_first.h"
#include "core/simplify/fusion/hierarchical.h"
#include "reference/door/request_options.h"
#include "reference/palpate/methods.h"
#include "reference/simplifier_support/fusion_run.h"

namespace palpate::reference {

Response run_hierarchical(const Request& request) {
  nlohmann::json left = request.options;
  simplify::SimplifyOptions options = take_fusion_options(request.stop, left);
  options.threads = request.threads;
  options.sizing = take_sizing_options(request.keep, left);
  require_all_taken(left);
  return run_fusion(request, [&](TetMesh& mesh) { return simplify::simplify_hierarchical(mesh, options); });
}

Response run_outcome(const Request& request) {
  nlohmann::json left = request.options;
  simplify::CheapestFirstOptions options;
  if (!left.contains("drop")) left["drop"] = options.common.drop;
  if (!left.contains("skip_touched")) left["skip_touched"] = options.common.skip_touched;
  if (!left.contains("last_level")) left["last_level"] = options.common.last_level;
  options.common = take_fusion_options(request.stop, left);
  options.common.threads = request.threads;
  options.common.sizing = take_sizing_options(request.keep, left);
  constexpr std::array kObjectives{simplify::CostObjective::kMovedLoss, simplify::CostObjective::kTotalLoss};
  options.objective = kObjectives[take_choice(left, "objective", {"moved_loss", "total_loss"})];
  options.many_passes = take_choice(left, "passes", {"many", "one"}) == 0;
  require_all_taken(left);
  return run_fusion(request, [&](TetMesh& mesh) { return simplify::simplify_cheapest_first(mesh, options); });
}

}  // namespace palpate::reference

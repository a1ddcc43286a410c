#include "experiments/contestants/solution.h"

#include "experiments/contestants/answer_cache.h"

namespace palpate::experiments {

Solution solve(const ContestantTask& task, const std::string& wanted,
               std::span<const std::filesystem::path> further) {
  Solution solution;
  solution.answer = run_cached(task, solution.was_kept, further);
  const ContestantAnswer& answer = solution.answer;
  solution.interrupted = answer.outcome == "interrupted";
  if (solution.interrupted) return solution;
  if (answer.outcome != "ok") {
    solution.outcome = answer.outcome;
    solution.failure = "ended: " + answer.message;
    return solution;
  }
  const std::string outcome = answer.report.at("outcome").get<std::string>();
  if (outcome == wanted) return solution;
  solution.outcome = "error";
  solution.failure = "ended with the outcome " + outcome;
  return solution;
}

nlohmann::json describe_solution(const Solution& solution, int refine) {
  return {{"refine", refine},
          {"kernel_s", *solution.answer.kernel_s},
          {"from_cache", solution.was_kept},
          {"report", solution.answer.report}};
}

}  // namespace palpate::experiments

// A contestant for the tests of the contest motion: a real process that answers with a ringing in closed
// form, or misbehaves as it is told.
#include <cmath>
#include <string>
#include <vector>

#include "reference/door/adapter.h"
#include "reference/door/motion_problem.h"

namespace {

using namespace palpate;
using reference::MotionHistory;
using reference::MotionProblem;
using reference::Request;
using reference::Response;

MotionHistory ring(const MotionProblem& problem, double size, double step_s) {
  MotionHistory history{reference::history_columns(problem), {}};
  const auto rows = static_cast<int>(std::lround(problem.duration_s / step_s));
  for (int k = 0; k <= rows; ++k) {
    const double time = problem.duration_s * k / rows;
    std::vector<double> row(history.columns.size(), size * std::exp(-2.0 * time) * std::cos(60.0 * time));
    row[0] = time;
    history.rows.push_back(std::move(row));
  }
  return history;
}

Response answer(const Request& request) {
  const std::string behave = request.options.value("behave", "ring");
  const reference::MotionTask task = reference::read_motion_task(request);
  Response response;
  response.kernel_s = 1e-6;
  response.report = {{"method", request.method}, {"outcome", behave == "diverge" ? "diverged" : "completed"}};
  std::vector<double> frequencies;
  for (std::size_t k = 0; k < task.problem.frequencies; ++k)
    frequencies.push_back(10.0 + static_cast<double>(k));
  if (behave == "few_frequencies") frequencies.pop_back();
  if (behave != "no_frequencies") response.report["frequencies_hz"] = frequencies;
  if (behave == "no_outcome") response.report.erase("outcome");
  if (behave == "diverge" || behave == "no_file") return response;
  const double error = request.options.value("bias", 0.0) / std::pow(4.0, request.options.value("refine", 0));
  MotionHistory history = ring(task.problem, request.options.value("factor", 1.0) * (1.0 + error),
                               request.options.value("time_step_s", 1e-3));
  if (behave == "short_file") history.rows.pop_back();
  write_history(request.output, history);
  return response;
}

}  // namespace

int main(int argc, char** argv) {
  return reference::run_adapter(argc, argv, answer);
}

// A contestant for the tests of the contest stability: a real process that answers as motion.symplectic_euler
// does, and then says or shows something else as it is told.
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "core/base/atomic_file.h"
#include "reference/door/json_file.h"
#include "reference/extremes/extreme_run.h"

namespace {

using namespace palpate;
using nlohmann::json;
using reference::Request;
using reference::Response;

/// Changes what the report says.
void change_report(const std::string& behave, json& report) {
  if (behave == "call_it_steady") {
    report["outcome"] = "steady";
    for (json& run : report["runs"]) run["outcome"] = "steady";
  }
  if (behave == "longer_step") report["measured_step_s"] = 1.01 * report["measured_step_s"].get<double>();
  if (behave == "no_outcome") report.erase("outcome");
  if (behave == "runs_are_numbers") report["runs"] = {1};
}

/// Changes what the file shows.
void change_history(const std::string& behave, json& answer) {
  json& run = answer["runs"][0];
  json& rows = run["rows"];
  json& bracket = answer["bracket"];
  const auto show = [&](const char* end, const char* shown) {
    const json step = bracket[end]["step_s"];
    bracket[end] = bracket[shown];
    bracket[end]["step_s"] = step;
  };
  if (behave == "lower_grows") show("lower", "upper");
  if (behave == "upper_is_stable") show("upper", "lower");
  if (behave == "no_bracket") bracket = nullptr;
  if (behave == "missing_rows") rows.erase(rows.begin() + 5, rows.begin() + 15);
  if (behave == "no_rows") rows.clear();
  if (behave == "other_farthest") rows.back()[8] = 2.0 * rows.back()[8].get<double>();
  if (behave == "other_mesh") run["displacement_m"].erase(0);
  if (behave == "words_for_numbers") rows[3][2] = "none";
  if (behave == "other_schema") answer["schema"] = "palpate/stability_answer/2";
}

Response answer(const Request& asked) {
  Request request = asked;
  const std::string behave = request.options.value("behave", "honest");
  request.options.erase("behave");
  if (behave == "few_steps") request.options["steps"] = 10;
  request.method = "motion.symplectic_euler";
  Response response = reference::run_extreme(request);
  change_report(behave, response.report);
  json history = reference::read_json_file(request.output);
  change_history(behave, history);
  std::string text = history.dump();
  if (behave == "truncated") text.resize(text.size() / 2);
  write_file_atomically(request.output, text);
  if (behave == "no_history") std::filesystem::remove(request.output);
  return response;
}

}  // namespace

int main(int argc, char** argv) {
  return reference::run_adapter(argc, argv, answer);
}

// gate.
#include <iostream>
#include <memory>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "experiments/commands/commands.h"
#include "experiments/files/places.h"
#include "experiments/records/run_folder.h"
#include "experiments/runner/gate.h"
#include "experiments/runner/gate_run.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

struct GateArguments {
  std::string run;
  std::string accepted;
  bool update = false;
  bool as_json = false;
};

std::string plan_of(const std::vector<json>& records, const fs::path& folder) {
  if (records.empty()) throw InputError(folder.string(), 0, "a run with records", "none");
  const json plan = records.front().value("plan", json());
  if (!plan.is_string()) throw InputError(folder.string(), 0, "records that name their plan", plan.dump());
  return plan.get<std::string>();
}

void print_gate(const GateResult& result) {
  TextTable table({"case", "measure", "accepted", "measured", "tolerance", "unit", ""}, "llrrrll");
  for (const GateLine& line : result.lines) {
    const bool holds = line.problem.empty();
    table.add(
        {line.run_case, line.measure, line.accepted ? short_number(*line.accepted) : "none",
         line.measured ? short_number(*line.measured) : "none",
         "-" + short_number(line.lower) + " +" + short_number(line.upper), line.unit,
         holds ? colored("holds", Color::kGreen) : colored("FAILS", Color::kRed) + ": " + line.problem});
  }
  std::cout << table.text();
  for (const std::string& problem : result.problems)
    std::cout << colored("FAILS", Color::kRed) << ": " << problem << '\n';
}

json describe_gate(const GateResult& result) {
  json lines = json::array();
  for (const GateLine& line : result.lines) {
    lines.push_back({{"case", line.run_case},
                     {"measure", line.measure},
                     {"unit", line.unit},
                     {"accepted", line.accepted ? json(*line.accepted) : json()},
                     {"measured", line.measured ? json(*line.measured) : json()},
                     {"lower", line.lower},
                     {"upper", line.upper},
                     {"holds", line.problem.empty()},
                     {"problem", line.problem}});
  }
  return {{"holds", result.holds()}, {"problems", result.problems}, {"figures", std::move(lines)}};
}

int gate(const GateArguments& arguments) {
  const fs::path folder = find_run(arguments.run);
  const auto records = read_run_records(folder);
  const std::string plan = plan_of(records, folder);
  const fs::path accepted = arguments.accepted.empty()
                                ? fs::path(source_folder()) / "results" / "accepted" / (plan + ".json")
                                : fs::path(arguments.accepted);
  const auto problems = find_run_problems(folder, records);
  const bool takes_over = arguments.update && problems.empty();
  if (arguments.update && !takes_over) print_note("the accepted figures are unchanged: the run is not sound");
  if (takes_over && !fs::exists(accepted)) {
    write_file_atomically(accepted, propose_accepted(folder, records, plan).dump(2) + "\n");
    print_note(accepted.string() + " is new: its tolerances are 0, widen them where a figure may move");
  }
  if (!problems.empty() && !fs::exists(accepted)) throw InputError(folder.string() + ": " + problems.front());
  GateResult result = hold_against(records, plan, accepted);
  if (takes_over) {
    const auto changes = update_accepted(result, accepted);
    for (const std::string& change : changes) print_note("accepted: " + change);
    if (changes.empty()) print_note("the accepted figures are unchanged");
    result = hold_against(records, plan, accepted);
  }
  result.problems = problems;
  if (arguments.as_json) {
    print_json(describe_gate(result));
  } else {
    print_gate(result);
  }
  return result.holds() ? kDone : kNotAccepted;
}

}  // namespace

void add_gate_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<GateArguments>();
  CLI::App* command = app.add_subcommand("gate", "Hold a run against accepted figures");
  command->add_option("RUN", arguments->run, "Run folder, or the folder of a plan's runs (the newest counts)")
      ->required();
  command
      ->add_option("--accepted", arguments->accepted,
                   "Accepted figures (default: results/accepted/<plan>.json)")
      ->type_name("FILE");
  command->add_flag("--update", arguments->update, "Take the run's figures over, tolerances kept");
  command->add_flag("--json", arguments->as_json, "Print the outcome as JSON");
  command->callback([arguments, &exit_code] { exit_code = gate(*arguments); });
}

}  // namespace palpate::experiments

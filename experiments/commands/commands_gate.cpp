// gate, history.
#include <filesystem>
#include <iostream>
#include <memory>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "experiments/commands/commands.h"
#include "experiments/files/output_file.h"
#include "experiments/files/places.h"
#include "experiments/files/plain_file.h"
#include "experiments/files/scratch_folder.h"
#include "experiments/gates/accept.h"
#include "experiments/gates/gate.h"
#include "experiments/gates/gate_report.h"
#include "experiments/gates/gate_run.h"
#include "experiments/judging/measure.h"
#include "experiments/processes/process.h"
#include "experiments/processes/report_script.h"
#include "experiments/records/provenance.h"
#include "experiments/records/run_folder.h"
#include "experiments/records/run_rows.h"
#include "experiments/text/nearest_name.h"
#include "experiments/text/terminal.h"
#include "reference/door/json_file.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

struct GateArguments {
  std::string run;
  std::string accepted;
  std::string junit;
  std::string markdown;
  std::vector<std::string> kinds;
  bool update = false;
  bool all = false;
  bool as_json = false;
};

/// The plan of a run, by its records or its provenance.
std::string plan_of(const RunRows& rows, const fs::path& folder) {
  const fs::path provenance = RunPaths{folder}.provenance();
  json plan;
  if (!rows.all().empty()) {
    plan = *rows.all().front().plan;
  } else if (fs::exists(provenance)) {
    plan = read_provenance(provenance).value("plan", json());
  }
  if (!plan.is_string()) throw InputError(folder.string(), 0, "a run that names its plan", plan.dump());
  return plan.get<std::string>();
}

std::vector<FigureKind> read_kinds(const GateArguments& arguments) {
  if (arguments.kinds.empty()) return default_kinds();
  if (!arguments.update) throw InputError("--kinds belongs to --update: it says what a new file takes");
  std::vector<FigureKind> kinds;
  for (const std::string& name : arguments.kinds) {
    const auto kind = kFigureKindNames.find(name);
    if (!kind) throw InputError("--kinds", 0, kFigureKindNames.known(), "\"" + name + "\"");
    kinds.push_back(*kind);
  }
  return kinds;
}

/// Where the accepted figures of a plan lie: the user's own, else those that came with the program.
fs::path find_accepted(const std::string& plan) {
  const fs::path name = fs::path("accepted") / (plan + ".json");
  const fs::path shipped = fs::path(source_folder()) / "results" / name;
  fs::path own = results_root() / name;
  return fs::exists(own) || !fs::exists(shipped) ? own : shipped;
}

fs::path accepted_path(const GateArguments& arguments, const std::string& plan) {
  return arguments.accepted.empty() ? find_accepted(plan) : fs::path(arguments.accepted);
}

/// The user's own file of accepted figures, for an update: what came with an installed program is copied
/// there, never changed.
fs::path take_accepted(const fs::path& found, const std::string& plan) {
  fs::path own = results_root() / "accepted" / (plan + ".json");
  create_folder(own.parent_path());
  if (own == found) return own;
  if (const auto bytes = read_bytes(found)) write_file_atomically(own, *bytes);
  return own;
}

/// The measures whose figures are needed of a run of `plan`. None where a file that names them cannot be
/// read: who holds the run against it says why.
std::vector<const Measure*> needed_measures(const GateArguments& arguments, const json& plan,
                                            const json& provenance) {
  if (!plan.is_string()) return {};
  const fs::path accepted = accepted_path(arguments, plan.get<std::string>());
  if (!fs::exists(accepted) && arguments.update) return measures_to_propose(provenance);
  if (!fs::exists(accepted)) return {};
  try {
    return measures_of(read_accepted(accepted, plan.get<std::string>()));
  } catch (const InputError&) {
    return {};
  }
}

/// The rows of a run with the figures that it is held by. Its provenance says what is needed before any
/// record is read; records that name another plan are read once more.
RunRows read_needed_rows(const GateArguments& arguments, const fs::path& folder) {
  const json provenance = known_provenance(folder);
  const auto read = [&](const json& plan) {
    return read_run_rows(folder, needed_measures(arguments, plan, provenance));
  };
  const json known = provenance.is_object() ? provenance.value("plan", json()) : json();
  RunRows rows = read(known);
  if (rows.all().empty() || *rows.all().front().plan == known) return rows;
  return read(*rows.all().front().plan);
}

/// Holds the run against the accepted file; if that is to be updated and the run is sound, updates it first.
GateResult hold_run(const GateArguments& arguments, const fs::path& folder,
                    std::vector<AcceptedChange>& changes) {
  const std::vector<FigureKind> kinds = read_kinds(arguments);
  const RunRows rows = read_needed_rows(arguments, folder);
  const std::string plan = plan_of(rows, folder);
  fs::path accepted = accepted_path(arguments, plan);
  std::vector<std::string> problems = find_run_problems(folder, rows);
  if (rows.all().empty()) problems.insert(problems.begin(), "nothing to compare: the run has no records");
  const bool takes_over = arguments.update && problems.empty();
  if (takes_over && arguments.accepted.empty()) accepted = take_accepted(accepted, plan);
  if (arguments.update && !takes_over) print_note("the accepted figures are unchanged: the run is not sound");
  if (takes_over && !fs::exists(accepted)) {
    write_file_atomically(accepted, propose_accepted(folder, rows, plan, kinds).dump(2) + "\n");
    print_note(accepted.string() + " is new: its tolerances are 0, widen them where a figure may move");
  }
  GateResult result;
  result.plan = plan;
  if (fs::exists(accepted)) {
    result = hold_against(rows, plan, accepted);
    if (takes_over) {
      changes = update_accepted(result, accepted);
      if (!changes.empty()) result = hold_against(rows, plan, accepted);
    }
  } else {
    const std::string next = problems.empty() ? "; palpate gate RUN --update writes them" : "";
    problems.push_back("nothing to compare: there are no accepted figures at " + accepted.string() + next);
  }
  result.problems.insert(result.problems.begin(), problems.begin(), problems.end());
  result.run = folder.string();
  return result;
}

/// A summary may replace an earlier one, and nothing that a run or a gate is read from.
void require_replaceable(const std::string& summary) {
  if (summary.empty() || !fs::is_regular_file(summary)) return;
  const std::string text = read_bytes(summary).value_or("");
  if (text.starts_with("{") || text.starts_with("schema:"))
    throw InputError(summary, 0, "a new file or an earlier summary", "a file of data");
}

int gate(const GateArguments& arguments) {
  require_replaceable(arguments.junit);
  require_replaceable(arguments.markdown);
  const auto place = [](const std::string& file) { return fs::weakly_canonical(fs::absolute(file)); };
  if (!arguments.junit.empty() && !arguments.markdown.empty() &&
      place(arguments.junit) == place(arguments.markdown))
    throw InputError("--markdown", 0, "another file than that of --junit", arguments.markdown);
  const fs::path folder = find_run(arguments.run);
  std::vector<AcceptedChange> changes;
  const GateResult result = hold_run(arguments, folder, changes);
  for (const AcceptedChange& change : changes) print_note("accepted: " + change.text());
  if (arguments.update && changes.empty() && result.holds()) print_note("the accepted figures are unchanged");
  if (!arguments.junit.empty()) write_file_atomically(arguments.junit, gate_junit(result));
  if (!arguments.markdown.empty()) write_file_atomically(arguments.markdown, gate_markdown(result, changes));
  if (arguments.as_json) {
    print_json(describe_gate(result, changes));
  } else {
    std::cout << gate_text(result, arguments.all);
  }
  return result.holds() ? kDone : kNotAccepted;
}

struct HistoryArguments {
  std::vector<std::string> folders;
  std::string out;
  std::string measure;
  bool as_json = false;
};

/// The measures for the script, which knows none by itself.
json describe_measures() {
  json all = json::array();
  for (const Measure& measure : list_measures()) {
    if (!measure.scalar) continue;
    all.push_back({{"name", measure.name},
                   {"unit", measure.unit},
                   {"better", measure.better},
                   {"key", measure.key},
                   {"anew", is_measured_anew(measure)}});
  }
  return all;
}

int history(const HistoryArguments& arguments) {
  if (!arguments.measure.empty()) {
    const Measure* measure = find_measure(arguments.measure);
    if (measure == nullptr || !measure->scalar)
      throw InputError("--measure: unknown measure \"" + arguments.measure + "\"" +
                       nearest_hint(arguments.measure, measure_names()));
  }
  for (const std::string& folder : arguments.folders) {
    std::error_code error;
    if (!fs::is_directory(folder, error))
      throw InputError(folder, 0, "a run, or a folder of runs", "no folder");
  }
  if (!arguments.out.empty()) create_folder(arguments.out);
  const ScratchFolder scratch;
  ProcessSpec spec = report_script("make_history.py", {"--measures", scratch.file("measures.json").string()});
  write_file_atomically(scratch.file("measures.json"), describe_measures().dump() + "\n");
  if (!arguments.out.empty()) spec.arguments.insert(spec.arguments.end(), {"--out", arguments.out});
  if (!arguments.measure.empty())
    spec.arguments.insert(spec.arguments.end(), {"--measure", arguments.measure});
  if (arguments.as_json) spec.arguments.emplace_back("--json");
  spec.arguments.emplace_back("--");
  spec.arguments.insert(spec.arguments.end(), arguments.folders.begin(), arguments.folders.end());
  const ScriptAnswer answer = run_script(std::move(spec), scratch, "the history");
  std::cout << answer.output;
  return answer.exit_code;
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
  command
      ->add_option("--kinds", arguments->kinds,
                   "With --update, kinds that a new file takes (accuracy,validity,stability,hash)")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->type_name("KIND,...");
  command->add_option("--junit", arguments->junit, "Write the outcome as JUnit XML, too")->type_name("FILE");
  command->add_option("--markdown", arguments->markdown, "Write a summary in Markdown, too")
      ->type_name("FILE");
  command->add_flag("--all", arguments->all, "Print what holds, too");
  command->add_flag("--json", arguments->as_json, "Print the outcome as JSON");
  command->footer(
      "Exit codes: 0 all figures hold; 1 one does not, the run is not sound, or there is nothing to "
      "compare.\n"
      "docs/gates.md has the kinds of figures: accuracy, validity, stability, hash, comparison, time_ratio.");
  command->callback([arguments, &exit_code] { exit_code = gate(*arguments); });
}

void add_history_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<HistoryArguments>();
  CLI::App* command = app.add_subcommand("history", "Follow figures over many runs, and find steps");
  command->add_option("DIR", arguments->folders, "Run folders, or folders of runs (results/<plan>)")
      ->required();
  command->add_option("-o,--out", arguments->out, "Write history.csv, steps.csv and charts there")
      ->type_name("FOLDER");
  command
      ->add_option("--measure", arguments->measure,
                   "This measure alone (default: those that the runs' plans name, and kernel_s)")
      ->type_name("NAME");
  command->add_flag("--json", arguments->as_json, "Print as JSON");
  command->footer(
      "A step is a level that changed and stayed; docs/gates.md has the rule. The largest comes first.");
  command->callback([arguments, &exit_code] { exit_code = history(*arguments); });
}

}  // namespace palpate::experiments

// compare.
#include <iostream>
#include <memory>

#include "core/base/error.h"
#include "experiments/commands/commands.h"
#include "experiments/commands/usage.h"
#include "experiments/files/plain_file.h"
#include "experiments/files/scratch_folder.h"
#include "experiments/judging/measure.h"
#include "experiments/plan_reader/plan_report.h"
#include "experiments/processes/process.h"
#include "experiments/processes/report_script.h"
#include "experiments/records/run_folder.h"
#include "experiments/text/nearest_name.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

struct CompareArguments {
  std::string run_a;
  std::string run_b;
  std::vector<std::string> measures;
  bool as_json = false;
  double fail_above = 0.0;  ///< 0: nothing fails
};

/// A file of Google Benchmark as it is, otherwise the run that a folder holds or has the newest of.
fs::path find_side(const std::string& given) {
  std::error_code error;
  return fs::is_regular_file(given, error) ? fs::path(given) : find_run(given);
}

/// A measure of a run as the report takes it, NAME:POINTER:UNIT:KIND.
std::string describe_measure(const std::string& name) {
  const Measure* measure = find_measure(name);
  if (measure == nullptr)
    throw InputError("--measure: unknown measure \"" + name + "\"" + nearest_hint(name, measure_names()));
  if (!measure->scalar) throw InputError("--measure: \"" + name + "\" is a list, a single number is needed");
  const bool is_of_process = is_clock_time(name) || name == "peak_rss_bytes";
  return name + ":" + measure->key + ":" + measure->unit + ":" + (is_of_process ? "clock" : "");
}

int compare_runs(const CompareArguments& arguments) {
  const std::vector<fs::path> sides{find_side(arguments.run_a), find_side(arguments.run_b)};
  std::vector<std::string> words{sides[0].string(), sides[1].string()};
  for (const std::string& name : arguments.measures) {
    words.emplace_back("--measure");
    words.push_back(fs::is_directory(sides[0]) ? describe_measure(name) : name);
  }
  if (arguments.as_json) words.emplace_back("--json");
  if (arguments.fail_above > 0.0) {
    words.emplace_back("--fail-above");
    words.push_back(nlohmann::json(arguments.fail_above).dump());
  }
  const ScratchFolder scratch;
  const ScriptAnswer answer = run_script(report_script("compare_runs.py", words), scratch, "the comparison");
  std::cout << answer.output;
  return answer.exit_code;
}

}  // namespace

void add_compare_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<CompareArguments>();
  CLI::App* command = app.add_subcommand("compare", "Hold two runs against each other, case by case");
  command
      ->add_option("A", arguments->run_a,
                   "Run folder, the folder of a plan's runs (the newest counts), or a\n"
                   "JSON file of Google Benchmark with repetitions")
      ->required();
  command->add_option("B", arguments->run_b, "What it is compared with")->required();
  command
      ->add_option("--measure", arguments->measures,
                   "What is compared (default: kernel_s and wall_s, or real_time and\n"
                   "cpu_time); repeatable")
      ->allow_extra_args(false)
      ->type_name("M");
  command->add_flag("--json", arguments->as_json, "Print the comparison as JSON");
  command
      ->add_option("--fail-above", arguments->fail_above,
                   "Exit with 1 if the whole interval of some ratio B / A is above R")
      ->check(number_from(1e-6, 1e6))
      ->type_name("R");
  command->footer(
      "Ratios of medians with 95% intervals and Mann and Whitney's test; what differs between the runs\n"
      "comes first, and times of different answers are not compared. docs/compare.md has the formulas.\n"
      "Exit codes: 0 compared; 1 --fail-above; 2 no run, no case in both, or nothing that --fail-above\n"
      "can decide.");
  command->callback([arguments, &exit_code] { exit_code = compare_runs(*arguments); });
}

}  // namespace palpate::experiments

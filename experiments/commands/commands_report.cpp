// report.
#include <filesystem>
#include <iostream>
#include <memory>

#include "core/base/error.h"
#include "experiments/commands/commands.h"
#include "experiments/files/file_bytes.h"
#include "experiments/files/scratch_folder.h"
#include "experiments/processes/report_script.h"
#include "experiments/records/run_folder.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

struct ReportArguments {
  std::vector<std::string> runs;
  std::string out;
};

int report_runs(const ReportArguments& arguments) {
  if (arguments.runs.size() > 1 && arguments.out.empty())
    throw InputError("-o: a page of several runs needs a file of its own: -o FILE");
  std::vector<std::string> words;
  for (const std::string& run : arguments.runs) words.push_back(find_run(run).string());
  if (!arguments.out.empty()) {
    words.emplace_back("--output");
    words.push_back(arguments.out);
  }
  const ScratchFolder scratch;
  ProcessSpec spec = page_script(arguments.runs.size() > 1 ? "compare_page.py" : "make_report.py", words);
  spec.standard_output = scratch.file("out");
  spec.standard_error = scratch.file("error");
  const ProcessResult result = run_process(spec);
  std::cout << read_bytes(spec.standard_output).value_or("");
  if (result.end == ProcessEnd::kInterrupted) return kInterrupted;
  if (result.end == ProcessEnd::kExited && result.exit_code == kBadInput)
    throw InputError(last_line(spec.standard_error));
  if (result.end != ProcessEnd::kExited || result.exit_code > kNotAccepted)
    throw UnavailableError("the report failed (" + result.message + "): " + last_line(spec.standard_error));
  const fs::path page =
      arguments.out.empty() ? fs::path(words.front()) / "report.html" : fs::path(arguments.out);
  std::cout << "\nPage: " << page.string() << '\n';
  return result.exit_code;
}

}  // namespace

void add_report_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<ReportArguments>();
  CLI::App* command =
      app.add_subcommand("report", "Tables, charts and page of a run, anew; a comparison of several");
  command
      ->add_option("RUN", arguments->runs,
                   "Run folder, or the folder of a plan's runs (the newest counts). Of\n"
                   "several runs the first is compared with each other one")
      ->required();
  command
      ->add_option("-o,--output", arguments->out,
                   "The page (default: RUN/report.html; needed for several runs)")
      ->type_name("FILE");
  command->footer(
      "The page is one file that opens offline in any browser: question, verdict, what was not accepted,\n"
      "charts, tables, meshes in 3D, provenance. docs/report_page.md says how to read it.\n"
      "Exit codes: 0 written; 1 written, and something that the plan requires does not hold; 2 no run.");
  command->callback([arguments, &exit_code] { exit_code = report_runs(*arguments); });
}

}  // namespace palpate::experiments

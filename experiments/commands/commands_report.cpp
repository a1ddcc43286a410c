// report and archive.
#include <filesystem>
#include <iostream>
#include <memory>

#include "core/base/error.h"
#include "experiments/commands/commands.h"
#include "experiments/files/output_file.h"
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

struct ArchiveArguments {
  std::string run;
  std::string out;
};

bool is_archive(const fs::path& folder) {
  std::error_code error;
  return fs::exists(folder / "archive.json", error);
}

/// The folder of a run that an archive becomes.
fs::path unpack(const fs::path& archive, const std::string& out, const ScratchFolder& scratch) {
  if (out.empty())
    throw InputError(archive.string() + ": an archive is unpacked into a folder of its own: -o FOLDER");
  create_folder(out);
  run_script(report_script("archive_run.py", {"--unpack", archive.string(), out}), scratch, "the archive");
  return out;
}

/// What the pages of these runs are made from.
std::vector<fs::path> files_of_runs(const std::vector<std::string>& folders) {
  std::vector<fs::path> files;
  for (const std::string& folder : folders) {
    for (const char* name : {"records.jsonl", "retried.jsonl", "provenance.json", "plan.yaml"})
      files.push_back(fs::path(folder) / name);
  }
  return files;
}

int report_runs(const ReportArguments& arguments) {
  const bool many = arguments.runs.size() > 1;
  if (many && arguments.out.empty())
    throw InputError("-o: a page of several runs needs a file of its own: -o FILE");
  const ScratchFolder scratch;
  std::vector<std::string> words;
  fs::path page = arguments.out;
  if (!many && is_archive(arguments.runs.front())) {
    words.push_back(unpack(arguments.runs.front(), arguments.out, scratch).string());
    page.clear();
  } else {
    for (const std::string& run : arguments.runs) {
      if (is_archive(run))
        throw InputError(run + ": an archive; unpack it first: palpate report ARCHIVE -o FOLDER");
      words.push_back(find_run(run).string());
    }
  }
  refuse_output_over_input("-o", page, files_of_runs(words));
  if (page.empty()) {
    page = fs::path(words.front()) / "report.html";
  } else {
    words.insert(words.end(), {"--output", page.string()});
  }
  const ScriptAnswer answer =
      run_script(page_script(many ? "compare_page.py" : "make_report.py", words), scratch, "the report");
  std::cout << answer.output;
  if (answer.exit_code != kInterrupted) std::cout << "\nPage: " << page.string() << '\n';
  return answer.exit_code;
}

int archive_run(const ArchiveArguments& arguments) {
  const ScratchFolder scratch;
  create_folder(arguments.out);
  const ScriptAnswer answer =
      run_script(report_script("archive_run.py", {find_run(arguments.run).string(), arguments.out}), scratch,
                 "the archive");
  std::cout << answer.output;
  return answer.exit_code;
}

}  // namespace

void add_report_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<ReportArguments>();
  CLI::App* command =
      app.add_subcommand("report", "Tables, charts and page of a run, anew; a comparison of several");
  command
      ->add_option("RUN", arguments->runs,
                   "Run folder, or the folder of a plan's runs (the newest counts), or an\n"
                   "archive. Of several runs the first is compared with each other one")
      ->required();
  command
      ->add_option("-o,--output", arguments->out,
                   "The page (default: RUN/report.html; needed for several runs). Of an\n"
                   "archive: the folder that it is unpacked into, with tables, charts and page")
      ->type_name("PATH");
  command->footer(
      "The page is one file that opens offline in any browser: question, verdict, what was not accepted,\n"
      "charts, tables, meshes in 3D, provenance. docs/report_page.md says how to read it.\n"
      "Exit codes: 0 written; 1 written, and something that the plan requires does not hold; 2 no run.");
  command->callback([arguments, &exit_code] { exit_code = report_runs(*arguments); });
}

void add_archive_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<ArchiveArguments>();
  CLI::App* command = app.add_subcommand("archive", "A run's records for good, small: `report` reads them");
  command->add_option("RUN", arguments->run, "Run folder, or the folder of a plan's runs (the newest counts)")
      ->required();
  command->add_option("-o,--output", arguments->out, "The archive: a new or an empty folder")
      ->required()
      ->type_name("DIR");
  command->footer(
      "The folder gets plan.yaml, provenance.json, records.jsonl.xz and archive.json with their number and "
      "sum:\n"
      "all that tables, charts and verdict are made from. Meshes and fields stay behind, so a page of an\n"
      "archive has no 3D. The same records make the same bytes.");
  command->callback([arguments, &exit_code] { exit_code = archive_run(*arguments); });
}

}  // namespace palpate::experiments

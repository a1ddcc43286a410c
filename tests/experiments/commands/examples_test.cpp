// The examples in docs/examples, as a reader would use them: a contestant in Python through a plan, and the
// shell lines of the workflow.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <sstream>

#include "experiments/files/places.h"
#include "experiments/processes/process.h"
#include "experiments/records/record_file.h"
#include "experiments/text/yaml_value.h"
#include "tests/support/experiment_fixture.h"
#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

fs::path examples() {
  return fs::path(source_folder()) / "docs/examples";
}

/// The steps of the workflow's only job.
json workflow_steps() {
  return read_yaml(examples() / "hosted_ci/palpate.yml").json().at("jobs").at("gate").at("steps");
}

/// The shell lines of the steps, those that install left out.
std::vector<std::string> workflow_lines() {
  std::vector<std::string> lines;
  for (const json& step : workflow_steps()) {
    const std::string run = step.value("run", "");
    if (!run.empty() && run.find("apt-get") == std::string::npos) lines.push_back(run);
  }
  return lines;
}

/// The words of each palpate command in the lines: up to the end of the line, or to what the shell takes.
std::vector<std::vector<std::string>> palpate_commands(const std::vector<std::string>& blocks) {
  std::vector<std::vector<std::string>> commands;
  for (const std::string& block : blocks) {
    std::istringstream lines(block);
    for (std::string line; std::getline(lines, line);) {
      std::istringstream words(line);
      std::string word;
      words >> word;
      if (word != "palpate/palpate") continue;
      commands.emplace_back();
      while (words >> word && word != ">" && word != "|") commands.back().push_back(word);
    }
  }
  return commands;
}

TEST(Examples, TheAdaptersAreShort) {
  for (const char* name : {"python_simplifier", "python_simulator"}) {
    const std::string text = test::bytes_of(examples() / name / "adapter.py");
    EXPECT_LT(std::count(text.begin(), text.end(), '\n'), 60) << name;
  }
}

/// The simplifier through a real run, against the figures that the example of a gate has accepted. Its ratio
/// of times is a measurement, and left to people.
TEST(Examples, TheSimplifierRunsAndItsAcceptedFiguresHold) {
  const test::ScratchFolder folder;
  const fs::path run = folder / "run";
  const test::ProgramResult ran = test::run_program(
      {"run", (examples() / "python_simplifier/merge_contest.yaml").string(), "--out", run.string()});
  ASSERT_EQ(ran.exit_code, 0) << ran.error << ran.out;
  const test::ProgramResult gate = test::run_program(
      {"gate", run.string(), "--accepted", (examples() / "hosted_ci/accepted.json").string(), "--json"});
  const json said = json::parse(gate.out);
  EXPECT_EQ(said.at("problems"), json::array());
  std::size_t held = 0;
  for (const json& figure : said.at("figures")) {
    if (figure.at("kind") == "time_ratio") continue;
    EXPECT_TRUE(figure.at("holds").get<bool>()) << figure;
    ++held;
  }
  EXPECT_EQ(held, 12U);
  for (const json& record : read_records(run / "records.jsonl")) {
    if (record.at("label") != "mine") continue;
    EXPECT_EQ(record.at("outcome"), "accepted");
    EXPECT_LE(record.at("judge").at("tets"), 0.7 * 1296);
    EXPECT_GT(record.at("judge").at("tets"), 0.69 * 1296)
        << "no merger of an inner vertex takes away more than some ten";
  }
}

TEST(Examples, EachOtherStopOfTheSimplifier) {
  const test::ScratchFolder folder;
  const auto tets_after = [&](const std::string& stop) {
    const auto plan = folder.add(
        "plan.yaml", "schema: palpate/plan/1\nquestion: q\ncontest: simplify\ncontestant_folders: [" +
                         (examples() / "python_simplifier").string() +
                         "]\nmeshes: [{name: cube, make: cube, vertices: 125}]\ncontestants: "
                         "[{method: mine.merge, stop: " +
                         stop + "}]\n");
    const fs::path run = folder / "run";
    fs::remove_all(run);
    const test::ProgramResult ran =
        test::run_program({"run", plan.string(), "--out", run.string(), "--no-report"});
    EXPECT_EQ(ran.exit_code, 0) << ran.error << ran.out;
    return read_records(run / "records.jsonl").back().at("judge").at("tets").get<int>();
  };
  const int most = tets_after("{tets: 300}");
  EXPECT_LE(most, 300);
  EXPECT_GT(most, 270);
  EXPECT_LT(tets_after("{limit: true}"), most) << "as far as it goes";
}

TEST(Examples, TheWorkflowsCommandsTakeTheirFlags) {
  const auto commands = palpate_commands(workflow_lines());
  ASSERT_EQ(commands.size(), 3U);
  for (const std::vector<std::string>& command : commands) {
    const test::ProgramResult help = test::run_program({command.at(0), "--help"});
    EXPECT_EQ(help.exit_code, 0) << command[0];
    for (const std::string& word : command) {
      if (word.rfind('-', 0) != 0) continue;
      const bool is_known = help.out.find(" " + word + " ") != std::string::npos ||
                            help.out.find(" " + word + ",") != std::string::npos;
      EXPECT_TRUE(is_known) << command[0] << " " << word;
    }
  }
  for (const json& step : workflow_steps())
    EXPECT_TRUE(step.contains("run") != step.contains("uses")) << step;
}

/// The workflow's own lines, one after the other, by sh -e as the service has it in a container. Installing
/// and checking out are left out.
TEST(Examples, TheWorkflowsLinesRun) {
  const test::ScratchFolder folder;
  fs::create_directory(folder / "palpate");
  fs::create_symlink(fs::path(program_folder()) / "palpate", folder / "palpate/palpate");
  fs::copy(examples() / "python_simplifier", folder / "benchmarks", fs::copy_options::recursive);
  json accepted = json::parse(test::bytes_of(examples() / "hosted_ci/accepted.json"));
  auto& figures = accepted.at("figures");
  figures.erase(std::remove_if(figures.begin(), figures.end(),
                               [](const json& f) { return f.at("kind") == "time_ratio"; }),
                figures.end());
  folder.add("benchmarks/accepted.json", accepted.dump());
  std::string script = "cd '" + folder.path().string() +
                       "'\nexport HOME=$PWD RUN=runs/1234-1 GITHUB_STEP_SUMMARY=$PWD/summary.md\n";
  for (const std::string& lines : workflow_lines()) script += "(set -e\n" + lines + "\n) || exit 1\n";
  ProcessSpec spec;
  spec.arguments = {"/bin/sh", folder.add("lines.sh", script).string()};
  spec.standard_output = folder / "out";
  spec.standard_error = folder / "error";
  const ProcessResult result = run_process(spec);
  EXPECT_EQ(result.exit_code, 0) << result.message << test::bytes_of(folder / "error");
  const std::string summary = test::bytes_of(folder / "summary.md");
  EXPECT_THAT(summary, HasSubstr("## palpate gate holds: merge"));
  EXPECT_THAT(summary, HasSubstr(" of 1 runs"));
  EXPECT_THAT(test::bytes_of(folder / "gate.xml"), HasSubstr("failures=\"0\""));
}

}  // namespace
}  // namespace palpate::experiments

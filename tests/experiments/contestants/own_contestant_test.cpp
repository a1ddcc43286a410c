// Contestants that somebody else brings: any command, anywhere, named by the plan; and what they say when
// they break.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/base/error.h"
#include "experiments/contestants/contestant_run.h"
#include "experiments/files/places.h"
#include "experiments/processes/child/sanitizers.h"
#include "experiments/records/record_file.h"
#include "experiments/registry/description.h"
#include "experiments/runner/read_plan.h"
#include "tests/support/experiment_fixture.h"

namespace palpate::experiments {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

constexpr const char* kCopies = R"(import json, shutil, sys, time
request = json.load(open(sys.argv[-2]))
shutil.copyfile(request["mesh_in"], request["mesh_out"])
json.dump({"schema": "palpate/response/1", "status": "ok", "kernel_s": 1e-6, "report": {}}, open(sys.argv[-1], "w"))
)";

/// A folder "mine" with a Python adapter, in a scratch folder beside a plan that names it.
class OwnContestant : public testing::Test {
 protected:
  OwnContestant() { fs::create_directories(elsewhere_ / "mine"); }

  void describe(const std::string& start) const {
    elsewhere_.add("mine/contestant.yaml",
                   "schema: palpate/contestant/1\ncontest: simplify\n" + start +
                       "\nlicence: MIT\nmethods: [{name: own.copy, summary: s, stops: [limit]}]\n");
  }
  void write_adapter(const std::string& text) const { elsewhere_.add("mine/adapter.py", text); }

  Contestant contestant() const {
    return read_description(elsewhere_ / "mine/contestant.yaml", "/bin/folder").at(0);
  }

  /// What one run of the adapter gives.
  ContestantAnswer answer() const {
    const Registry registry({contestant()});
    const fs::path scratch = elsewhere_ / "scratch";
    fs::create_directory(scratch);
    ContestantTask task;
    task.method = *registry.find("own.copy");
    task.mesh_in = fixture_.folder() / "cube.mesh";
    task.scratch = scratch;
    task.options = json::object();
    task.timeout_s = 60.0;
    task.memory_mib = 512;
    return run_contestant(task);
  }

  test::ProgramResult run_plan(const std::string& folders) const {
    const auto plan = elsewhere_.add(
        "own.yaml", "schema: palpate/plan/1\nquestion: q\nmeshes: [{name: cube, file: " +
                        (fixture_.folder() / "cube.mesh").string() +
                        "}]\ncontest: simplify\ncontestants: [own.copy]\n" + folders + "run: {repeats: 2}\n");
    const fs::path out = elsewhere_ / "run";
    fs::remove_all(out);
    return test::run_program({"run", plan.string(), "--out", out.string(), "--no-report"});
  }
  json record() const { return read_records(elsewhere_ / "run/records.jsonl").back(); }

  test::ExperimentFixture fixture_;
  test::ScratchFolder elsewhere_;
};

TEST_F(OwnContestant, ACommandNeedsNoExecutableAndNoEnvironment) {
  describe("command: [python3, -B, adapter.py, --fast]");
  write_adapter(kCopies);
  const Contestant own = contestant();
  EXPECT_EQ(own.program.filename(), "python3");
  EXPECT_TRUE(own.program.is_absolute()) << own.program;
  EXPECT_THAT(own.command, testing::ElementsAre(own.program.string(), "-B",
                                                (elsewhere_ / "mine/adapter.py").string(), "--fast"));
  EXPECT_EQ(own.unavailable(), "");
  const test::ProgramResult done = run_plan("contestant_folders: [mine]\n");
  EXPECT_EQ(done.exit_code, 0) << done.error;
  EXPECT_EQ(record().at("outcome"), "accepted");
  const json programs = json::parse(test::bytes_of(elsewhere_ / "run/provenance.json")).at("programs");
  EXPECT_TRUE(programs.contains("mine/adapter.py")) << programs;
  EXPECT_TRUE(programs.contains("mine/python3")) << programs;
  EXPECT_EQ(test::run_program({"check", (elsewhere_ / "own.yaml").string()}).exit_code, 0);
}

TEST_F(OwnContestant, ThePlanSaysWhereOrNobodyKnowsIt) {
  describe("command: [python3, adapter.py]");
  write_adapter(kCopies);
  EXPECT_THAT(run_plan("").error, HasSubstr("unknown method \"own.copy\""));
  EXPECT_EQ(run_plan("contestant_folders: [.]\n").exit_code, 0) << "a folder of such folders";
  EXPECT_THAT(run_plan("contestant_folders: [yours]\n").error, HasSubstr("own.yaml:6: no folder "));
  EXPECT_THAT(run_plan("contestant_folders: []\n").error, HasSubstr("at least one folder"));
  EXPECT_EQ(run_plan("contestant_folders: [mine, ./mine, .]\n").exit_code, 0)
      << "found three times, one contestant";
}

TEST_F(OwnContestant, AChangedScriptIsAnotherContestant) {
  describe("command: [python3, adapter.py]\nfiles: [weights.txt]");
  write_adapter(kCopies);
  EXPECT_THAT(contestant().unavailable(), HasSubstr("weights.txt is missing"));
  elsewhere_.add("mine/weights.txt", "1");
  EXPECT_EQ(contestant().unavailable(), "");
  const std::string before = hash_contestant(contestant());
  EXPECT_EQ(hash_contestant(contestant()), before);
  elsewhere_.add("mine/weights.txt", "2");
  const std::string other_file = hash_contestant(contestant());
  EXPECT_NE(other_file, before);
  write_adapter(std::string(kCopies) + "\n");
  EXPECT_NE(hash_contestant(contestant()), other_file);
  const auto plan = elsewhere_ / "own.yaml";
  ASSERT_EQ(run_plan("contestant_folders: [mine]\n").exit_code, 0);
  write_adapter(kCopies);
  EXPECT_THAT(
      test::run_program({"run", plan.string(), "--out", (elsewhere_ / "run").string(), "--resume"}).error,
      HasSubstr("the program mine/adapter.py changed"));
}

TEST_F(OwnContestant, DescriptionsThatSayTooMuchOrTooLittle) {
  const auto error_of = [&](const std::string& start) -> std::string {
    describe(start);
    try {
      contestant();
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_THAT(error_of("command: [python3]\nprogram: p"), HasSubstr("a program or a command, not both"));
  EXPECT_THAT(error_of("command: []"), HasSubstr("a list of words that starts with a program"));
  EXPECT_THAT(error_of("packages: []"), HasSubstr("program"));
  EXPECT_EQ(error_of("command: [no-such-program-anywhere, adapter.py]"), "no error");
  EXPECT_EQ(contestant().unavailable(), "its program no-such-program-anywhere is not in PATH");
  EXPECT_EQ(error_of("command: [./solver]"), "no error");
  EXPECT_THAT(contestant().unavailable(), HasSubstr("its program solver was not built"));
}

TEST_F(OwnContestant, ATracebackStandsInTheMessageAndTheRecord) {
  describe("command: [python3, adapter.py]");
  write_adapter("def half(x):\n    return x / 0\n\nhalf(1)\n");
  const ContestantAnswer crashed = answer();
  EXPECT_EQ(crashed.outcome, "crashed");
  EXPECT_THAT(crashed.message, HasSubstr("exit code 1 without an answer: "));
  EXPECT_THAT(crashed.message,
              HasSubstr("line 2, in half | return x / 0 | ZeroDivisionError: division by zero"));
  EXPECT_THAT(crashed.standard_error, testing::StartsWith("Traceback (most recent call last):\n"));
  const test::ProgramResult run = run_plan("contestant_folders: [mine]\n");
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.out, HasSubstr("ZeroDivisionError: division by zero"));
  EXPECT_THAT(record().at("stderr").get<std::string>(), HasSubstr("ZeroDivisionError"));
}

TEST_F(OwnContestant, ACountThatIsWrongOrNoneIsAViolation) {
  describe("command: [python3, adapter.py]");
  const auto outcome = [&](const std::string& report) {
    std::string text = kCopies;
    write_adapter(text.replace(text.find("\"report\": {}"), 12, "\"report\": " + report));
    run_plan("contestant_folders: [mine]\n");
    return record().at("outcome").get<std::string>() + " " + record().at("violations").dump();
  };
  EXPECT_EQ(outcome("{\"tets_in\": 384, \"tets_out\": 384, \"vertices_out\": 125}"), "accepted []");
  EXPECT_EQ(outcome("{\"tets_in\": None, \"tets_out\": 384.0}"), "accepted []");
  EXPECT_THAT(outcome("{\"tets_out\": 383}"), HasSubstr("reports tets_out 383, the judge counts 384"));
  EXPECT_THAT(outcome("{\"tets_out\": \"NaN\"}"),
              HasSubstr("rejected [\"reports tets_out \\\"NaN\\\", the judge"));
  EXPECT_THAT(outcome("{\"tets_in\": [1]}"), HasSubstr("reports tets_in [1], the input has 384"));
  EXPECT_THAT(outcome("{\"vertices_in\": True}"), HasSubstr("reports vertices_in true, the input has 125"));
  EXPECT_THAT(outcome("{\"vertices_out\": {\"x\": 1}}"), HasSubstr("the judge counts 125"));
}

TEST_F(OwnContestant, WhatABadAnswerWroteIsSaid) {
  describe("command: [python3, adapter.py]");
  write_adapter("import sys\nprint('no mesh today', file=sys.stderr)\nopen(sys.argv[2], 'w').write('{}')\n");
  const ContestantAnswer bad = answer();
  EXPECT_EQ(bad.outcome, "bad_answer");
  EXPECT_EQ(bad.message, "its answer's schema is not palpate/response/1; it wrote: no mesh today");
}

TEST_F(OwnContestant, AnAcceptedRecordKeepsNoneOfIt) {
  describe("command: [python3, adapter.py]");
  write_adapter(std::string("import sys\nprint('well', file=sys.stderr)\n") + kCopies);
  EXPECT_EQ(run_plan("contestant_folders: [mine]\n").exit_code, 0);
  EXPECT_FALSE(record().contains("stderr"));
}

TEST_F(OwnContestant, TheTailIsBoundedAndValidWhateverIsWritten) {
  describe("command: [python3, adapter.py]");
  // 3000 times a character of two bytes that starts at an odd place, then bytes that are no UTF-8, and
  // escapes.
  write_adapter(
      "import sys\nsys.stderr.buffer.write(b'x' + 'ä'.encode() * 3000 + b'\\xff' * 700 + "
      "b'\\x1b[31mend\\n')\nsys.exit(4)\n");
  const ContestantAnswer crashed = answer();
  EXPECT_LE(crashed.standard_error.size(), 4096U);
  EXPECT_GE(crashed.standard_error.size(), 4094U);
  EXPECT_NO_THROW(json(crashed.standard_error).dump()) << "no valid UTF-8";
  EXPECT_THAT(crashed.standard_error, testing::EndsWith("\x1b[31mend\n"));
  for (const char c : crashed.message) EXPECT_TRUE(c >= 32 && c < 127) << static_cast<int>(c);
  EXPECT_LE(crashed.message.size(), 400U);
}

TEST_F(OwnContestant, PythonsLackOfMemoryIsNoCrash) {
  if (kIsSanitized) GTEST_SKIP() << "AddressSanitizer leaves no room for a bound";
  describe("command: [python3, adapter.py]");
  write_adapter("x = bytearray(1 << 40)\n");
  EXPECT_EQ(answer().outcome, "out_of_memory");
}

}  // namespace
}  // namespace palpate::experiments

#include "experiments/contestants/contestant_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/base/error.h"
#include "experiments/files/places.h"
#include "experiments/processes/child/sanitizers.h"
#include "experiments/registry/description.h"
#include "tests/support/experiment_fixture.h"
#include "tests/support/test_folder.h"

namespace palpate::experiments {
namespace {

using testing::HasSubstr;

ContestantAnswer run_behaviour(const test::ExperimentFixture& fixture, const std::string& behave,
                               double timeout_s = 60.0,
                               const nlohmann::json& tuned = nlohmann::json::object()) {
  const auto scratch = fixture.folder() / behave;
  std::filesystem::create_directory(scratch);
  ContestantTask task;
  task.method = *fixture.registry().find("test.copy");
  task.mesh_in = fixture.folder() / "cube.mesh";
  task.scratch = scratch;
  task.options = resolve_options(*task.method.method, {{"behave", {behave, "test"}}});
  task.tuned = tuned;
  task.timeout_s = timeout_s;
  task.memory_mib = 512;
  return run_contestant(task);
}

TEST(ContestantRun, GoodAnswer) {
  const test::ExperimentFixture fixture;
  const ContestantAnswer answer = run_behaviour(fixture, "copy");
  EXPECT_EQ(answer.outcome, "ok") << answer.message;
  EXPECT_EQ(answer.report.at("tets_in"), 384);
  EXPECT_GE(*answer.wall_s, *answer.kernel_s);
  EXPECT_GT(*answer.peak_rss_bytes, 0U);
  EXPECT_EQ(test::bytes_of(answer.output), test::bytes_of(fixture.folder() / "cube.mesh"));
}

/// A behaviour, and the outcome and words that it has to give.
struct Misbehaviour {
  const char* behave;
  const char* outcome;
  const char* message;
};

void PrintTo(const Misbehaviour& tested, std::ostream* out) {
  *out << tested.behave;
}

class Misbehaviours : public testing::TestWithParam<Misbehaviour> {};

TEST_P(Misbehaviours, BecomesAnOutcome) {
  if (kIsSanitized && GetParam().outcome == std::string("out_of_memory"))
    GTEST_SKIP() << "AddressSanitizer leaves no room for a bound";
  const test::ExperimentFixture fixture;
  const ContestantAnswer answer = run_behaviour(fixture, GetParam().behave);
  EXPECT_EQ(answer.outcome, GetParam().outcome) << answer.message;
  EXPECT_THAT(answer.message, HasSubstr(GetParam().message));
  EXPECT_TRUE(answer.report.is_null());
}

const Misbehaviour kMisbehaviours[] = {
    {"crash", "crashed", "signal 11"},
    {"no_answer", "crashed", "exit code 5 without an answer: cannot go on"},
    {"garbage", "bad_answer", "its answer: expected JSON"},
    {"deep_answer", "bad_answer", "its answer: expected at most 32 levels of nesting"},
    {"huge_answer", "bad_answer", "its answer is a file of 20971520 bytes, where 16777216 are the most"},
    {"nan_time", "bad_answer", "its answer: expected a number, found NaN"},
    {"negative_time", "bad_answer", "kernel_s is no time above zero"},
    {"zero_time", "bad_answer", "kernel_s is no time above zero: 0.0"},
    {"long_time", "bad_answer", "its kernel time of 1000 s exceeds the"},
    {"overwrite_input", "bad_answer", "it changed its input cube.mesh"},
    {"no_time", "bad_answer", "\"kernel_s\" is missing"},
    {"wrong_keys", "bad_answer", "unknown key \"kernel_seconds\""},
    {"no_mesh", "bad_answer", "wrote no mesh"},
    {"false_status", "bad_answer", "answered \"ok\" and left with exit code 3"},
    {"tune_text", "bad_answer", "tuned parameter length is no number: \"half\""},
    {"refuse", "bad_input", "not this mesh"},
    {"fail", "error", "not this mesh"},
    {"memory", "out_of_memory", "bad_alloc"},
};

std::string behaviour_name(const testing::TestParamInfo<Misbehaviour>& tested) {
  return tested.param.behave;
}

INSTANTIATE_TEST_SUITE_P(All, Misbehaviours, testing::ValuesIn(kMisbehaviours), behaviour_name);

TEST(ContestantRun, WhatASearchFoundIsHandedBack) {
  const nlohmann::json given{{"length", 0.25}};
  {
    const test::ExperimentFixture fixture;
    const ContestantAnswer first = run_behaviour(fixture, "tune");
    EXPECT_EQ(first.outcome, "ok") << first.message;
    EXPECT_EQ(first.tuned, (nlohmann::json{{"length", 0.5}}));
    EXPECT_TRUE(first.searched);
  }
  {
    const test::ExperimentFixture fixture;
    const ContestantAnswer later = run_behaviour(fixture, "tune", 60.0, given);
    EXPECT_EQ(later.tuned, given);
    EXPECT_FALSE(later.searched);
  }
  const test::ExperimentFixture fixture;
  const ContestantAnswer changed = run_behaviour(fixture, "tune_anew", 60.0, given);
  EXPECT_EQ(changed.outcome, "bad_answer");
  EXPECT_THAT(changed.message, HasSubstr("not those it was given: {\"length\":0.75}"));
}

TEST(ContestantRun, AMethodWithoutASearchHasNothingTuned) {
  const test::ExperimentFixture fixture;
  const ContestantAnswer answer = run_behaviour(fixture, "copy");
  EXPECT_TRUE(answer.tuned.empty());
  EXPECT_FALSE(answer.searched);
}

TEST(ContestantRun, HangEndsAtTheTimeOut) {
  const test::ExperimentFixture fixture;
  const ContestantAnswer answer = run_behaviour(fixture, "hang", 1.0);
  EXPECT_EQ(answer.outcome, "timed_out");
  EXPECT_EQ(answer.message, "timed out after 1 s");
}

TEST(ContestantRun, ProgramThatWasNotBuilt) {
  const test::ScratchFolder folder;
  std::filesystem::create_directory(folder / "ghost");
  folder.add(
      "ghost/contestant.yaml",
      "schema: palpate/contestant/1\ncontest: simplify\nprogram: ghost_program\npackages: [libghost-dev]\n"
      "licence: MIT\nmethods: [{name: ghost.walk, summary: none, stops: [limit]}]\n");
  const Registry registry(read_description(folder / "ghost/contestant.yaml", experiments::program_folder()));
  ContestantTask task;
  task.method = *registry.find("ghost.walk");
  task.scratch = folder.path();
  const ContestantAnswer answer = run_contestant(task);
  EXPECT_EQ(answer.outcome, "unavailable");
  EXPECT_THAT(answer.message, HasSubstr("needs libghost-dev"));
}

/// A contestant as somebody else would bring one: a folder with a description and a script.
constexpr const char* kOwnDescription =
    "schema: palpate/contestant/1\ncontest: simplify\nprogram: %s\nlicence: MIT\n"
    "methods: [{name: own.copy, summary: copies, stops: [limit]}]\n";
constexpr const char* kOwnScript = R"(#!/usr/bin/python3
import json, shutil, sys, time
request = json.load(open(sys.argv[1]))
start = time.monotonic()
shutil.copyfile(request["mesh_in"], request["mesh_out"])
answer = {"schema": "palpate/response/1", "status": "ok", "kernel_s": time.monotonic() - start, "report": {}, "notes": []}
json.dump(answer, open(sys.argv[2], "w"))
)";

std::string own_description(const char* program) {
  std::string text = kOwnDescription;
  return text.replace(text.find("%s"), 2, program);
}

TEST(Contestant, MayLiveElsewhere) {
  const test::ExperimentFixture fixture;
  const test::ScratchFolder elsewhere;
  std::filesystem::create_directories(elsewhere / "mine/bin");
  const auto script = elsewhere.add("mine/bin/solver.py", kOwnScript);
  std::filesystem::permissions(script, std::filesystem::perms::owner_all);
  elsewhere.add("mine/contestant.yaml", own_description("bin/solver.py"));
  ::setenv("PALPATE_CONTESTANTS", elsewhere.path().c_str(), 1);
  const Registry registry = load_registry();
  ASSERT_TRUE(registry.find("own.copy"));
  EXPECT_EQ(registry.find("own.copy")->contestant->unavailable(), "");
  const auto plan = fixture.add_plan("[own.copy]");
  const auto run = [&](const std::string& name) {
    return test::run_program(
        {"run", plan.string(), "--out", (fixture.folder() / name).string(), "--no-report"});
  };
  const test::ProgramResult done = run("run");
  EXPECT_EQ(done.exit_code, 0) << done.error;
  EXPECT_EQ(fixture.records().at("cube/own.copy").at("outcome"), "accepted");
  const auto provenance = nlohmann::json::parse(test::bytes_of(fixture.folder() / "run/provenance.json"));
  EXPECT_TRUE(provenance.at("programs").contains("mine/solver.py")) << provenance.at("programs").dump();
  std::filesystem::permissions(script, std::filesystem::perms::owner_read);
  EXPECT_THAT(run("again").error, HasSubstr("solver.py is not executable"));
}

TEST(Contestant, AProgramIsLookedForBesideItsDescriptionFirst) {
  const test::ScratchFolder folder;
  const auto program_of = [&](const char* program) {
    const auto file = folder.add("contestant.yaml", own_description(program));
    return read_description(file, "/bin/folder").at(0).program;
  };
  EXPECT_EQ(program_of("solver"), "/bin/folder/solver");
  const auto own = folder.add("solver", "");
  EXPECT_EQ(program_of("solver"), own);
  EXPECT_EQ(program_of("./solver"), own);
  EXPECT_EQ(program_of("../build/solver"), folder.path().parent_path() / "build/solver");
  EXPECT_EQ(program_of("/opt/solver"), "/opt/solver");
}

std::string description_error(const std::string& methods) {
  const test::ScratchFolder folder;
  const auto file =
      folder.add("contestant.yaml",
                 "schema: palpate/contestant/1\ncontest: simplify\nprogram: p\nlicence: MIT\nmethods:\n" +
                     methods + "\n");
  try {
    read_description(file, folder.path());
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Contestant, DescriptionErrorsNameTheLine) {
  EXPECT_THAT(description_error("  - {name: a, summary: s, stops: [fusion]}"),
              HasSubstr("contestant.yaml:6: unknown stop \"fusion\"; did you mean \"fusions\"?"));
  EXPECT_THAT(description_error("  - {name: a, sumary: s, stops: [limit]}"),
              HasSubstr("did you mean \"summary\"?"));
  EXPECT_THAT(description_error("  - {name: a, summary: s, stops: [limit], deterministic: perhaps}"),
              HasSubstr("expected true or false"));
  EXPECT_THAT(description_error("  - {name: a, summary: s, stops: []}"), HasSubstr("has no stop"));
  const std::string method = "  - {name: a, summary: s, stops: [limit], options: [";
  EXPECT_THAT(description_error(method + "{name: o, type: real, default: 1, help: h}]}"),
              HasSubstr("expected choice, number, integer, bool or file"));
  EXPECT_THAT(description_error(method + "{name: o, type: number, min: 2, default: 1, help: h}]}"),
              HasSubstr("a number, at least 2"));
  EXPECT_THAT(description_error(method + "{name: o, type: choice, default: 1, help: h}]}"),
              HasSubstr("choices belong to the type choice"));
}

TEST(Contestant, OptionsAreTypedAndComplete) {
  const test::ExperimentFixture fixture;
  const MethodSpec& method = *fixture.registry().find("test.copy")->method;
  const nlohmann::json options =
      resolve_options(method, {{"factor", {"0.25", "--set"}}, {"flag", {"true", "--set"}}});
  EXPECT_EQ(options.at("factor"), 0.25);
  EXPECT_EQ(options.at("flag"), true);
  EXPECT_EQ(options.at("seed"), 0);
  EXPECT_EQ(options.at("behave"), "copy");
  EXPECT_EQ(options.size(), method.options.size());
}

TEST(Contestant, AMethodThatKeepsRegionsHasTheirOptions) {
  const test::ExperimentFixture fixture;
  const MethodSpec& keeper = *fixture.registry().find("test.keep")->method;
  EXPECT_TRUE(keeper.keeps);
  EXPECT_EQ(resolve_options(keeper, {}).at("near_size"), 0.5);
  EXPECT_EQ(resolve_options(keeper, {{"reach", {"2.5", "--set"}}}).at("reach"), 2.5);
  const MethodSpec& other = *fixture.registry().find("test.copy")->method;
  EXPECT_FALSE(other.keeps);
  EXPECT_EQ(other.find_option("near_size"), nullptr);
  EXPECT_THAT(
      description_error("  - {name: a, summary: s, stops: [limit], keep: true, options: [{name: reach, "
                        "type: number, default: 1, help: h}]}"),
      HasSubstr("option \"reach\" twice"));
}

TEST(Contestant, MethodsHaveTheOptionSetsThatTheyName) {
  const Registry registry = load_registry();
  const MethodSpec& fitted = *registry.find("springs.isotropy_patch")->method;
  EXPECT_NE(fitted.find_option("calibrate"), nullptr);
  EXPECT_NE(fitted.find_option("volume"), nullptr);
  EXPECT_NE(fitted.find_option("solver"), nullptr) << "belongs to all methods";
  const MethodSpec& trained = *registry.find("springs.trained")->method;
  EXPECT_EQ(trained.find_option("calibrate"), nullptr);
  EXPECT_NE(trained.find_option("volume"), nullptr);
  EXPECT_THAT(description_error("  - {name: a, summary: s, stops: [limit], option_sets: [fit]}"),
              HasSubstr("contestant.yaml:6: no option set \"fit\""));
}

TEST(Contestant, SameMethodTwiceIsRefused) {
  const auto file = std::filesystem::path(test::test_folder()) / "contestant/contestant.yaml";
  const Contestant once = read_description(file, experiments::program_folder()).at(0);
  EXPECT_THROW(Registry({once, once}), InputError);
}

TEST(Contestant, OneDescriptionMayListSeveralContests) {
  const Registry registry = load_registry();
  const Contestant& still = *registry.find("springs.isotropy")->contestant;
  const Contestant& moving = *registry.find("moving_springs.isotropy")->contestant;
  EXPECT_EQ(still.folder, "springs");
  EXPECT_EQ(moving.folder, "springs");
  EXPECT_EQ(still.contest, "deform");
  EXPECT_EQ(moving.contest, "motion");
  EXPECT_EQ(still.program, moving.program);
  const MethodSpec& method = *registry.find("moving_springs.isotropy")->method;
  EXPECT_NE(method.find_option("integrator"), nullptr) << "belongs to all methods of its contest";
  EXPECT_NE(method.find_option("calibrate"), nullptr) << "a set of both contests";
  EXPECT_EQ(method.find_option("load_steps"), nullptr) << "belongs to the other contest";
}

TEST(Contestant, WhatBelongsToEachContestIsRefusedAboveThem) {
  const test::ScratchFolder folder;
  const auto error_of = [&](const std::string& rest) -> std::string {
    const auto file =
        folder.add("contestant.yaml", "schema: palpate/contestant/1\nprogram: p\nlicence: MIT\n" + rest);
    try {
      read_description(file, folder.path());
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  };
  const std::string one = "contests:\n  - contest: step\n    methods: [{name: a, summary: s}]\n";
  EXPECT_EQ(error_of(one), "no error");
  EXPECT_THAT(error_of("contest: step\n" + one), HasSubstr("contest belongs to each of the contests"));
  EXPECT_THAT(error_of("contests: []\n"), HasSubstr("at least one contest"));
  EXPECT_THAT(error_of("contests: [{contest: step, methods: [], licence: MIT}]\n"),
              HasSubstr("unknown key \"licence\""));
}

}  // namespace
}  // namespace palpate::experiments

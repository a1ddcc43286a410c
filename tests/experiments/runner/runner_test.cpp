#include "experiments/runner/runner.h"
#include "experiments/files/places.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <map>
#include <thread>

#include "core/base/error.h"
#include "core/base/random.h"
#include "experiments/processes/process.h"
#include "experiments/records/record_file.h"
#include "experiments/runner/read_plan.h"
#include "tests/support/experiment_fixture.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using testing::HasSubstr;

/// Runs a plan quietly in this process.
RunResult run_quietly(const test::ExperimentFixture& fixture, const std::filesystem::path& file,
                      const std::filesystem::path& folder, bool resume = false,
                      const std::string& case_id = "") {
  const Plan plan = read_plan(file, fixture.registry());
  RunOptions options;
  options.folder = folder;
  options.resume = resume;
  options.case_id = case_id;
  Progress progress(true);
  return run_plan(plan, fixture.registry(), options, progress);
}

std::map<std::string, std::vector<json>> records_by_case(const std::filesystem::path& folder) {
  std::map<std::string, std::vector<json>> all;
  for (json& record : read_records(folder / "records.jsonl")) {
    all[record.at("case").get<std::string>()].push_back(std::move(record));
  }
  return all;
}

TEST(Runner, RecordsEveryRepeatInRounds) {
  const test::ExperimentFixture fixture;
  const auto plan =
      fixture.add_plan("\n  - test.copy\n  - {method: test.copy, label: seeded, seeds: 2}",
                       "run: {repeats: 2, warmup: 1}\naccept: {boundary_changed_faces: {max: 0}}\n");
  const auto folder = fixture.folder() / "run";
  const RunResult result = run_quietly(fixture, plan, folder);
  EXPECT_FALSE(result.required_failed);
  EXPECT_FALSE(result.required_rejected);
  std::vector<std::string> order;
  for (const json& record : read_records(folder / "records.jsonl")) {
    EXPECT_EQ(record.at("outcome"), "accepted") << record.dump();
    order.push_back(record.at("case").get<std::string>() + "#" + record.at("repeat").dump() +
                    (record.at("warmup").get<bool>() ? "w" : ""));
  }
  EXPECT_THAT(order, testing::ElementsAre("cube/input#0", "cube/test.copy#0w", "cube/seeded/seed=1#0w",
                                          "cube/seeded/seed=2#0w", "cube/test.copy#1", "cube/seeded/seed=1#1",
                                          "cube/seeded/seed=2#1", "cube/test.copy#2", "cube/seeded/seed=1#2",
                                          "cube/seeded/seed=2#2"));
  EXPECT_EQ(test::bytes_of(folder / "plan.yaml"), test::bytes_of(plan));
  EXPECT_TRUE(std::filesystem::exists(folder / "meshes/cube/seeded/seed=2.mesh"));
  EXPECT_FALSE(std::filesystem::exists(folder / ".scratch"));
  EXPECT_EQ(json::parse(test::bytes_of(folder / "provenance.json")).at("meshes").size(), 1U);
}

TEST(Runner, OutcomesOfBadContestants) {
  const test::ExperimentFixture fixture;
  std::string contestants;
  const std::map<std::string, std::string> expected{{"invert", "rejected"},     {"drop_tet", "rejected"},
                                                    {"move_skin", "rejected"},  {"false_count", "rejected"},
                                                    {"nan_mesh", "bad_answer"}, {"crash", "crashed"},
                                                    {"hang", "timed_out"},      {"refuse", "bad_input"}};
  for (const auto& [behave, outcome] : expected) {
    contestants += "\n  - {method: test.copy, label: " + behave + ", set: {behave: " + behave + "}}";
  }
  const auto plan = fixture.add_plan(
      contestants, "run: {repeats: 2, timeout_s: 1}\naccept: {boundary_changed_faces: {max: 0}}\n");
  const RunResult result = run_quietly(fixture, plan, fixture.folder() / "run");
  EXPECT_TRUE(result.required_failed);
  EXPECT_TRUE(result.required_rejected);
  const auto records = records_by_case(fixture.folder() / "run");
  for (const auto& [behave, outcome] : expected) {
    const json& record = records.at("cube/" + behave).front();
    EXPECT_EQ(record.at("outcome"), outcome) << behave << ": " << record.dump();
    EXPECT_NE(record.at("message"), "") << behave;
  }
  EXPECT_EQ(records.at("cube/crash").size(), 2U);
  EXPECT_EQ(records.at("cube/hang").size(), 1U) << "a time-out is not repeated";
  EXPECT_EQ(records.at("cube/refuse").size(), 1U);
  EXPECT_THAT(records.at("cube/false_count")[0].at("message").get<std::string>(),
              HasSubstr("the judge counts 384"));
  EXPECT_THAT(records.at("cube/nan_mesh")[0].at("message").get<std::string>(), HasSubstr("out.mesh:5"));
  EXPECT_EQ(records.at("cube/crash")[0].at("null_reasons").at("kernel_s"), "crashed");
}

TEST(Runner, ABrokenPromiseToKeepARegionIsAViolation) {
  const test::ExperimentFixture fixture;
  // 384 tets in [0, 1]^3; half_space 0 0 -1 -0.9 is z >= 0.9, the top layer of 96.
  const std::string region = "keep: [half_space 0 0 -1 -0.9]";
  const auto plan = fixture.add_plan("\n  - {method: test.keep, label: keeps, " + region +
                                         "}\n  - {method: test.keep, label: breaks, " + region +
                                         ", set: {behave: drop_tet}}\n  - {method: test.copy, label: free}",
                                     "region: [half_space 0 0 1 0.1]\naccept: {kept_tets_changed: {max: 0}, "
                                     "region_tets: {min: 96, max: 96}}\n");
  run_quietly(fixture, plan, fixture.folder() / "run");
  const auto records = records_by_case(fixture.folder() / "run");
  const json& keeps = records.at("cube/keeps").front();
  EXPECT_EQ(keeps.at("outcome"), "accepted") << keeps.dump();
  EXPECT_EQ(keeps.at("keep"), json({"half_space 0 0 -1 -0.9"}));
  EXPECT_EQ(keeps.at("judge").at("kept_tets"), 96);
  EXPECT_EQ(keeps.at("judge").at("kept_tets_changed"), 0);
  const json& breaks = records.at("cube/breaks").front();
  EXPECT_EQ(breaks.at("outcome"), "rejected");
  EXPECT_EQ(breaks.at("judge").at("kept_tets_changed"), 1);
  EXPECT_THAT(breaks.at("violations").dump(), HasSubstr("kept_tets_changed is 1, at most 0 is accepted"));
  const json& free = records.at("cube/free").front();
  EXPECT_EQ(free.at("outcome"), "accepted");
  EXPECT_EQ(free.at("judge").at("kept_tets"), 0);
  EXPECT_EQ(free.at("judge").at("region_tets"), 96);
  EXPECT_EQ(records.at("cube/input").front().at("judge").at("region_tets"), 96);
  const json provenance = json::parse(test::bytes_of(fixture.folder() / "run/provenance.json"));
  EXPECT_THAT(provenance.at("plan_data").dump(), HasSubstr("half_space 0 0 -1 -0.9"));
}

TEST(Runner, AContestantThatChangesItsInputHarmsNobodyElse) {
  const test::ExperimentFixture fixture;
  const auto folder = fixture.folder() / "run";
  ::setenv("PALPATE_TEST_SOURCE_MESH", (folder / "meshes/cube/input.mesh").c_str(), 1);
  const auto plan = fixture.add_plan(
      "\n  - {method: test.copy, label: a, set: {behave: overwrite_input}}\n  - {method: test.copy, label: "
      "b, "
      "set: {behave: overwrite_source}}\n  - {method: test.copy, label: c}");
  run_quietly(fixture, plan, folder);
  ::unsetenv("PALPATE_TEST_SOURCE_MESH");
  const auto records = records_by_case(folder);
  for (const char* spoiler : {"cube/a", "cube/b"}) {
    EXPECT_EQ(records.at(spoiler).front().at("outcome"), "bad_answer");
    EXPECT_EQ(records.at(spoiler).front().at("message"), "it changed its input input.mesh") << spoiler;
    EXPECT_TRUE(records.at(spoiler).front().at("kernel_s").is_null());
  }
  const json& next = records.at("cube/c").front();
  EXPECT_EQ(next.at("outcome"), "accepted") << next.dump();
  EXPECT_EQ(next.at("report").at("tets_in"), 384) << "it was given the whole mesh";
  EXPECT_EQ(test::bytes_of(folder / "meshes/cube/input.mesh"),
            test::bytes_of(fixture.folder() / "cube.mesh"));
}

TEST(Runner, OptionalContestantDoesNotDecide) {
  const test::ExperimentFixture fixture;
  const auto plan = fixture.add_plan(
      "\n  - test.copy\n  - {method: test.copy, label: b, set: {behave: crash}, required: false}");
  const RunResult result = run_quietly(fixture, plan, fixture.folder() / "run");
  EXPECT_FALSE(result.required_failed);
  EXPECT_EQ(result.failures.count("cube/b"), 1U);
}

TEST(Runner, ASearchIsMadeOnceACase) {
  const test::ExperimentFixture fixture;
  const auto plan =
      fixture.add_plan("[{method: test.copy, label: a, set: {behave: tune}}, {method: test.copy, label: b}]",
                       "run: {repeats: 2, warmup: 1}\n");
  const auto folder = fixture.folder() / "run";
  run_quietly(fixture, plan, folder);
  const auto records = records_by_case(folder);
  const auto& a = records.at("cube/a");
  ASSERT_EQ(a.size(), 3U);
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].at("outcome"), "accepted") << a[i].dump();
    EXPECT_EQ(a[i].at("tuned"), (json{{"length", 0.5}}));
    EXPECT_EQ(a[i].at("searched"), i == 0);
  }
  for (const json& record : records.at("cube/b")) {
    EXPECT_EQ(record.at("tuned"), json::object());
    EXPECT_EQ(record.at("searched"), false);
  }
}

TEST(Runner, AResumedRunHandsBackWhatASearchFound) {
  const test::ExperimentFixture fixture;
  const std::string contestants = "[{method: test.copy, label: a, set: {behave: tune}}]";
  const auto folder = fixture.folder() / "run";
  const auto plan = fixture.add_plan(contestants, "run: {repeats: 3}\n");
  run_quietly(fixture, plan, folder);
  // As if it had been stopped after the first repeat, with another length found.
  std::string kept;
  for (json& record : read_records(folder / "records.jsonl")) {
    if (record.at("repeat") != 0) continue;
    if (record.at("label") == "a") record["tuned"] = {{"length", 0.125}};
    kept += record.dump() + "\n";
  }
  fixture.folder().add("run/records.jsonl", kept);
  run_quietly(fixture, plan, folder, true);
  const auto records = records_by_case(folder);
  const auto& a = records.at("cube/a");
  ASSERT_EQ(a.size(), 3U);
  for (std::size_t i = 1; i < a.size(); ++i) {
    EXPECT_EQ(a[i].at("tuned"), (json{{"length", 0.125}}));
    EXPECT_EQ(a[i].at("searched"), false);
  }
}

TEST(Runner, AMethodThatIsNotDeterministicIsJudgedInEachRepeat) {
  const test::ExperimentFixture fixture;
  const auto plan = fixture.add_plan("[{method: test.varying, label: a}]", "run: {repeats: 6}\n");
  run_quietly(fixture, plan, fixture.folder() / "run");
  int differing = 0;
  const auto records = records_by_case(fixture.folder() / "run");
  for (const json& record : records.at("cube/a")) {
    EXPECT_EQ(record.at("outcome"), "accepted") << record.dump();
    EXPECT_TRUE(record.at("judge").at("valid").get<bool>());
    differing +=
        record.at("notes").dump().find("output differs between repeats") != std::string::npos ? 1 : 0;
  }
  EXPECT_GE(differing, 1) << "six times the same of 97 rotations";
}

TEST(Runner, AnotherOutputInARepeatIsAViolation) {
  const test::ExperimentFixture fixture;
  const auto plan =
      fixture.add_plan("[{method: test.copy, label: a, set: {behave: alternate}}]", "run: {repeats: 6}\n");
  run_quietly(fixture, plan, fixture.folder() / "run");
  const auto records = records_by_case(fixture.folder() / "run").at("cube/a");
  EXPECT_EQ(records.front().at("outcome"), "accepted");
  std::size_t violations = 0;
  for (const json& record : records) {
    violations += record.at("violations") == json::array({"output differs between repeats"}) ? 1 : 0;
  }
  EXPECT_GT(violations, 0U);
}

TEST(Runner, TetsOfTakesTheOtherCasesCount) {
  const test::ExperimentFixture fixture;
  const auto plan = fixture.add_plan(
      "\n  - {method: test.copy, label: b, stop: {tets_of: a}}\n  - {method: test.copy, label: "
      "a, stop: {ratio: 0.5}}");
  run_quietly(fixture, plan, fixture.folder() / "run");
  const json stop = records_by_case(fixture.folder() / "run").at("cube/b")[0].at("stop");
  EXPECT_EQ(stop, json({{"kind", "tets"}, {"value", 384}, {"of", "a"}}));
}

TEST(Runner, TetsOfACaseWithoutAMeshIsAnError) {
  const test::ExperimentFixture fixture;
  const auto plan = fixture.add_plan(
      "\n  - {method: test.copy, label: b, stop: {tets_of: a}}\n  - {method: test.copy, label: a, set: "
      "{behave: crash}}");
  run_quietly(fixture, plan, fixture.folder() / "run");
  const json record = records_by_case(fixture.folder() / "run").at("cube/b")[0];
  EXPECT_EQ(record.at("outcome"), "error");
  EXPECT_THAT(record.at("message").get<std::string>(), HasSubstr("cube/a, which left no mesh"));
}

std::string run_error(const test::ExperimentFixture& fixture, const std::filesystem::path& plan,
                      const std::filesystem::path& folder, bool resume) {
  try {
    run_quietly(fixture, plan, folder, resume);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Runner, FolderThatCannotBeUsed) {
  const test::ExperimentFixture fixture;
  const auto plan = fixture.add_plan("[test.copy]");
  const auto folder = fixture.folder() / "run";
  std::filesystem::create_directory(fixture.folder() / "other");
  fixture.folder().add("other/letter.txt", "mine");
  for (const bool resume : {false, true}) {
    EXPECT_THAT(run_error(fixture, plan, fixture.folder() / "other", resume), HasSubstr("found other files"));
  }
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(fixture.folder() / "other"), {}), 1);
  EXPECT_THAT(run_error(fixture, plan, fixture.folder() / "cube.mesh/run", false),
              HasSubstr("can be written"));
  EXPECT_EQ(run_error(fixture, plan, folder, false), "no error");
  EXPECT_THAT(run_error(fixture, plan, folder, false), HasSubstr("holds a run already"));
  const FolderLock held(folder);
  EXPECT_THAT(run_error(fixture, plan, folder, true), HasSubstr("another run is at work"));
}

TEST(Runner, ResumeRefusesAnotherPlanAndChangedMeshes) {
  const test::ExperimentFixture fixture;
  const auto folder = fixture.folder() / "run";
  run_quietly(fixture, fixture.add_plan("[test.copy]"), folder);
  const auto other = fixture.add_plan("[test.copy]", "run: {repeats: 2}\n");
  EXPECT_THAT(run_error(fixture, other, folder, true), HasSubstr("the plan changed"));
  const auto same = fixture.add_plan("[test.copy]");
  EXPECT_EQ(run_error(fixture, same, folder, true), "no error");
  std::filesystem::copy_file(fixture.folder() / "cube.mesh", folder / "meshes/cube/input.mesh",
                             std::filesystem::copy_options::overwrite_existing);
  std::string bytes = test::bytes_of(folder / "meshes/cube/input.mesh");
  bytes.replace(bytes.find("End"), 3, "End\n");
  fixture.folder().add("run/meshes/cube/input.mesh", bytes);
  EXPECT_THAT(run_error(fixture, same, folder, true), HasSubstr("the mesh that the run started with"));
}

TEST(Runner, ResumeRefusesAnotherMachineOrCompiler) {
  const test::ExperimentFixture fixture;
  const auto plan = fixture.add_plan("\n  - test.copy\n  - {method: test.copy, label: b}");
  const auto folder = fixture.folder() / "run";
  run_quietly(fixture, plan, folder, false, "cube/b");
  const std::string own = test::bytes_of(folder / "provenance.json");
  for (const char* key : {"processor", "compiler", "flags", "system", "memory"}) {
    json elsewhere = json::parse(own);
    elsewhere[key] = "another";
    fixture.folder().add("run/provenance.json", elsewhere.dump());
    EXPECT_THAT(run_error(fixture, plan, folder, true), HasSubstr("changed (\"another\" then, ")) << key;
  }
  EXPECT_EQ(records_by_case(folder).size(), 2U) << "nothing was added";
  fixture.folder().add("run/provenance.json", own);
  run_quietly(fixture, plan, folder, true);
  const auto records = records_by_case(folder);
  EXPECT_EQ(records.at("cube/input")[0].at("sitting"), 0);
  EXPECT_EQ(records.at("cube/b")[0].at("sitting"), 0);
  EXPECT_EQ(records.at("cube/test.copy")[0].at("sitting"), 1);
  const json sittings = json::parse(test::bytes_of(folder / "provenance.json")).at("sittings");
  ASSERT_EQ(sittings.size(), 2U);
  for (const json& sitting : sittings)
    EXPECT_TRUE(sitting.contains("commit") && sitting.contains("started_at"));
}

TEST(Runner, OneCaseThenTheRest) {
  const test::ExperimentFixture fixture;
  const auto plan = fixture.add_plan("\n  - test.copy\n  - {method: test.copy, label: b, seeds: 3}");
  const auto folder = fixture.folder() / "run";
  run_quietly(fixture, plan, folder, false, "cube/b/seed=2");
  EXPECT_EQ(records_by_case(folder).size(), 2U);
  run_quietly(fixture, plan, folder, true);
  EXPECT_EQ(records_by_case(folder).size(), 5U);
  EXPECT_THROW(run_quietly(fixture, plan, folder, true, "cube/bb"), InputError);
}

TEST(Records, TornLineIsDroppedAndCutOff) {
  const test::ScratchFolder folder;
  const std::string line = R"({"schema":"palpate/record/1","case":"a","repeat":0,"outcome":"accepted"})"
                           "\n";
  const auto path = folder.add("records.jsonl", line + line.substr(0, 30));
  EXPECT_EQ(read_records(path).size(), 1U);
  { RecordFile(path).append(json::parse(line)); }
  EXPECT_EQ(read_records(path).size(), 2U);
  folder.add("records.jsonl", "garbage\n" + line);
  EXPECT_THROW(read_records(path), InputError);
  folder.add("records.jsonl", line + std::string(200'000, '[') + "\n");
  EXPECT_THROW(read_records(path), InputError) << "had overflowed the stack";
  folder.add("records.jsonl", std::string(100'000, 'x'));
  { const RecordFile cut(path); }
  EXPECT_EQ(std::filesystem::file_size(path), 0U);
}

TEST(Records, FullDiskIsSaid) {
  if (!std::filesystem::exists("/dev/full")) GTEST_FAIL() << "/dev/full is needed";
  RecordFile file("/dev/full");
  EXPECT_THROW(file.append(json::object()), InputError);
}

/// Starts `palpate run`, kills it by signal 9 after some time, and returns whether it was still at work.
bool start_and_kill(const std::vector<std::string>& arguments, std::chrono::microseconds after) {
  std::vector<std::string> words{experiments::program_folder() + "/palpate"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  pointers.reserve(words.size() + 1);
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  const pid_t child = ::fork();
  if (child == 0) {
    ::close(STDOUT_FILENO);
    ::close(STDERR_FILENO);
    ::execv(pointers[0], pointers.data());
    ::_exit(127);
  }
  std::this_thread::sleep_for(after);
  ::kill(child, SIGKILL);
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFSIGNALED(status);
}

TEST(Runner, KilledAnywhereItGoesOnWithoutLossOrRepetition) {
  const test::ExperimentFixture fixture;
  const auto plan =
      fixture.add_plan("\n  - {method: test.copy, label: slow, set: {delay_ms: 5}, seeds: 6}\n  - test.copy",
                       "run: {repeats: 3, warmup: 1}\n");
  const std::uint64_t seed = 20260131;
  SCOPED_TRACE("seed " + std::to_string(seed));
  SplitMix64 random(seed);
  const auto folder = fixture.folder() / "run";
  const std::vector<std::string> arguments{"run",           plan.string(), "--out",
                                           folder.string(), "--resume",    "--no-report"};
  int kills = 0;
  for (int attempt = 0; attempt < 12; ++attempt) {
    kills += start_and_kill(arguments, std::chrono::microseconds(2'000 + random.below(150'000))) ? 1 : 0;
  }
  EXPECT_GT(kills, 0);
  const test::ProgramResult last = test::run_program(arguments);
  EXPECT_EQ(last.exit_code, 0) << last.error;
  const auto records = records_by_case(folder);
  EXPECT_EQ(records.size(), 8U);
  for (const auto& [id, repeats] : records) {
    std::vector<int> numbers;
    for (const json& record : repeats) numbers.push_back(record.at("repeat").get<int>());
    if (id == "cube/input") {
      EXPECT_THAT(numbers, testing::ElementsAre(0));
    } else {
      EXPECT_THAT(numbers, testing::ElementsAre(0, 1, 2, 3)) << id;
      EXPECT_TRUE(std::filesystem::exists(folder / "meshes" / (id + ".mesh"))) << id;
    }
  }
}

}  // namespace
}  // namespace palpate::experiments

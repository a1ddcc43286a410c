// Runs that are stopped, killed and taken up again, and the file of records that survives it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "core/base/error.h"
#include "core/base/random.h"
#include "experiments/files/places.h"
#include "experiments/records/key_forms.h"
#include "experiments/records/record_file.h"
#include "experiments/runner/read_plan.h"
#include "experiments/runner/runner.h"
#include "tests/support/experiment_fixture.h"
#include "tests/support/quiet_run.h"
#include "tests/support/synced_files.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using test::records_by_case;
using test::run_error;
using test::run_quietly;
using testing::HasSubstr;

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

TEST(Runner, RecordsThatNobodyKnowsTheOriginOfAreNotContinued) {
  const test::ExperimentFixture fixture;
  const auto folder = fixture.folder() / "run";
  run_quietly(fixture, fixture.add_plan("[test.copy]"), folder);
  const auto other = fixture.add_plan("[test.copy]", "run: {repeats: 2}\n", "other");
  const std::string kept = test::bytes_of(folder / "plan.yaml");
  std::filesystem::remove(folder / "provenance.json");
  EXPECT_THAT(run_error(fixture, other, folder, true),
              HasSubstr("provenance.json: expected what the records beside it were made with"));
  EXPECT_EQ(test::bytes_of(folder / "plan.yaml"), kept);
  EXPECT_FALSE(std::filesystem::exists(folder / "provenance.json"));
  // Killed before its provenance was written, a run has no record either, and goes on.
  for (const char* records : {"", "none"}) {
    std::filesystem::remove(folder / "records.jsonl");
    if (std::string(records).empty()) fixture.folder().add("run/records.jsonl", records);
    std::filesystem::remove(folder / "provenance.json");
    EXPECT_EQ(run_error(fixture, other, folder, true), "no error");
    EXPECT_EQ(records_by_case(folder).size(), 2U);
  }
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

TEST(Runner, AnInterruptIsHeardBeforeTheNextMeshIsMade) {
  const test::ExperimentFixture fixture;
  const auto plan = fixture.add_plan("[test.copy]");
  const auto folder = fixture.folder() / "run";
  const volatile std::sig_atomic_t raised = 1;
  RunOptions options;
  options.folder = folder;
  options.stop_flag = &raised;
  Progress progress(true);
  EXPECT_TRUE(
      run_plan(read_plan(plan, fixture.registry()), fixture.registry(), options, progress).interrupted);
  EXPECT_FALSE(std::filesystem::exists(folder / "meshes/cube/input.mesh"));
  EXPECT_TRUE(run_quietly(fixture, plan, folder, true).is_whole);
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

TEST(Runner, WhatKilledProcessesWereWritingIsRemoved) {
  const test::ExperimentFixture fixture;
  const auto plan = fixture.add_plan("\n  - test.copy\n  - {method: test.copy, label: b}");
  const auto folder = fixture.folder() / "run";
  run_quietly(fixture, plan, folder, false, "cube/b");
  const pid_t gone = ::fork();
  if (gone == 0) ::_exit(0);
  ::waitpid(gone, nullptr, 0);
  const std::string left = ".partial-" + std::to_string(gone);
  const std::string alive = ".partial-" + std::to_string(::getppid());
  for (const char* file : {"provenance.json", "meshes/cube/b.mesh", "meshes/new.mesh"}) {
    for (const std::string& end : {left, alive}) fixture.folder().add("run/" + (file + end), "half");
  }
  for (const char* file : {"a.partial-", "a.partial-x", "a.partial-12x"})
    fixture.folder().add(std::string("run/") + file, "mine");
  run_quietly(fixture, plan, folder, true);
  for (const char* file : {"provenance.json", "meshes/cube/b.mesh", "meshes/new.mesh"}) {
    EXPECT_FALSE(std::filesystem::exists(folder / (file + left))) << file;
    EXPECT_TRUE(std::filesystem::exists(folder / (file + alive))) << file << ": it is at work";
  }
  for (const char* file : {"a.partial-", "a.partial-x", "a.partial-12x"})
    EXPECT_TRUE(std::filesystem::exists(folder / file)) << "not one of ours";
  EXPECT_EQ(records_by_case(folder).size(), 3U);
}

TEST(Runner, AnOutputLiesOnTheDiskBeforeItsRecord) {
  const test::ExperimentFixture fixture;
  const auto plan = fixture.add_plan("\n  - test.copy\n  - {method: test.copy, label: b}");
  const auto folder = fixture.folder() / "run";
  const test::SyncedFiles synced;
  run_quietly(fixture, plan, folder);
  const std::vector<std::filesystem::path> order = synced.paths();
  const auto place = [&order](const std::filesystem::path& file, std::size_t count = 1) {
    std::size_t at = 0;
    for (; at < order.size() && count > 0; ++at) count -= order[at] == file ? 1U : 0U;
    return count == 0 ? at : order.size() + 1;
  };
  std::size_t line = 0;
  std::size_t outputs = 0;
  for (const json& record : read_records(folder / "records.jsonl")) {
    ++line;
    if (record.at("contestant").is_null() || record.at("repeat") != 0) continue;
    const auto kept = folder / record.at("mesh_file").get<std::string>();
    EXPECT_LT(place(kept), place(folder / "records.jsonl", line)) << kept;
    EXPECT_LT(place(kept.parent_path()), place(folder / "records.jsonl", line)) << "and its name";
    ++outputs;
  }
  EXPECT_EQ(outputs, 2U);
}

TEST(Records, TornLineIsDroppedAndCutOff) {
  const test::ScratchFolder folder;
  const std::string line = R"({"schema":"palpate/record/1","case":"a","repeat":0,"outcome":"accepted"})"
                           "\n";
  const auto path = folder.add("records.jsonl", line + line.substr(0, 30));
  EXPECT_EQ(read_records(path).size(), 1U);
  json second = json::parse(line);
  second["repeat"] = 1;
  { RecordFile(path).append(second); }
  EXPECT_EQ(read_records(path).size(), 2U);
  folder.add("records.jsonl", "garbage\n" + line);
  EXPECT_THROW(read_records(path), InputError);
  folder.add("records.jsonl", line + std::string(200'000, '[') + "\n");
  EXPECT_THROW(read_records(path), InputError) << "had overflowed the stack";
  std::filesystem::resize_file(folder.add("records.jsonl", line), std::uint64_t{1} << 40U);
  EXPECT_THROW(RecordFile cut(path), InputError) << "a line without end, which is looked for from the end";
  folder.add("records.jsonl", std::string(100'000, 'x'));
  { const RecordFile cut(path); }
  EXPECT_EQ(std::filesystem::file_size(path), 0U);
}

TEST(Records, OneThatCouldNotBeReadAgainIsNotWritten) {
  const test::ScratchFolder folder;
  const auto path = folder / "records.jsonl";
  json record = {{"schema", "palpate/record/1"}, {"case", "a"}, {"repeat", 0}, {"outcome", "accepted"}};
  RecordFile file(path);
  file.append(record);
  record["message"] = std::string(kLongestRecord, 'x');
  EXPECT_THROW(file.append(record), InputError);
  EXPECT_EQ(read_records(path).size(), 1U);
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

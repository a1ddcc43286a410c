// Faults of the machine and of the people around a run: kills, full and read-only disks, two at a time.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <thread>

#include "core/base/random.h"
#include "experiments/files/places.h"
#include "experiments/processes/child/sanitizers.h"
#include "experiments/processes/process.h"
#include "experiments/records/record_file.h"
#include "tests/support/full_mode.h"
#include "tests/support/hostile_contestant.h"

namespace palpate::experiments {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::HostileContestant;
using test::StartedProgram;
using testing::HasSubstr;

/// Works for a while in three processes, one of them in a session of its own.
constexpr const char* kWorks = R"(
for i in range(2):
    if os.fork() == 0:
        if i == 0:
            os.setsid()
        time.sleep(3600)
open(here + "/started", "w").write("")
time.sleep(%s)
answer_well()
)";

std::string works_for(const std::string& seconds) {
  std::string text = kWorks;
  return text.replace(text.find("%s"), 2, seconds);
}

std::map<std::string, std::vector<std::string>> outcomes(const HostileContestant& contestant) {
  std::map<std::string, std::vector<std::string>> all;
  for (const json& record : contestant.records())
    all[record.at("case").get<std::string>()].push_back(record.at("outcome").get<std::string>());
  return all;
}

TEST(Faults, AKilledRunLeavesNoProcess) {
  for (const int number : {SIGKILL, SIGINT, SIGTERM, SIGHUP}) {
    const HostileContestant works(works_for("3600"));
    works.plan();
    StartedProgram run(works.run_words());
    ASSERT_TRUE(test::appears(works.folder() / "hostile/started")) << run.error();
    EXPECT_GE(works.processes().size(), 3U);
    run.signal(number);
    const bool in_order = number == SIGINT || number == SIGTERM;
    EXPECT_EQ(run.wait(), in_order ? 130 : -number) << run.error();
    EXPECT_TRUE(works.all_end()) << "after signal " << number;
    EXPECT_FALSE(outcomes(works).count("cube/hostile")) << "what was interrupted has no record";
  }
}

/// Starts a run again and again and kills it by signal 9 at random moments: what has its record keeps it,
/// once, and no process stays. Started a last time it ends with `wanted` records.
void kill_anywhere(const HostileContestant& works, const std::vector<std::string>& words,
                   std::size_t wanted) {
  const std::uint64_t seed = 20260208;
  SCOPED_TRACE("seed " + std::to_string(seed));
  SplitMix64 random(seed);
  const int kills = test::full_or(50, 6);
  std::set<std::string> finished;
  int at_work = 0;
  for (int i = 0; i < kills; ++i) {
    StartedProgram run(words);
    std::this_thread::sleep_for(std::chrono::microseconds(2'000 + random.below(250'000)));
    run.signal(SIGKILL);
    at_work += run.wait() == -SIGKILL ? 1 : 0;
    EXPECT_TRUE(works.all_end()) << "kill " << i;
    if (!fs::exists(works.out() / "records.jsonl")) continue;
    std::set<std::string> now;
    for (const json& record : works.records()) {
      EXPECT_EQ(record.at("outcome"), "accepted") << record.dump();
      EXPECT_TRUE(now.insert(record.at("case").dump() + record.at("repeat").dump()).second)
          << "twice: " << record.dump();
    }
    EXPECT_TRUE(std::includes(now.begin(), now.end(), finished.begin(), finished.end()))
        << "something is lost";
    finished = now;
  }
  EXPECT_GT(at_work, 0);
  const test::ProgramResult last = test::run_program(words);
  EXPECT_EQ(last.exit_code, 0) << last.error;
  EXPECT_EQ(works.records().size(), wanted);
  EXPECT_TRUE(works.processes().empty());
  for (const auto& entry : fs::recursive_directory_iterator(works.out()))
    EXPECT_EQ(entry.path().string().find(".partial-"), std::string::npos) << entry.path();
}

TEST(Faults, KilledAnywhereItGoesOnAndLeavesNoProcess) {
  const HostileContestant works(works_for("0.03"));
  works.plan("{repeats: 3, warmup: 1}");
  kill_anywhere(works, works.run_words(true), 1U + 3U * 4U);
}

TEST(Faults, KilledAnywhereSideBySideItGoesOnToo) {
  const HostileContestant works(works_for("0.03"));
  works.plan("{repeats: 4, timed: false}");
  std::vector<std::string> words = works.run_words(true);
  words.insert(words.end(), {"--jobs", "2"});
  kill_anywhere(works, words, 1U + 3U * 4U);
}

TEST(Faults, KilledAnywhereWhileItTakesPartsItGoesOnToo) {
  const HostileContestant works(works_for("0.01"));
  works.plan("{repeats: 3, warmup: 1}");
  const std::string part = (works.folder() / "part").string();
  std::vector<std::string> words = works.run_words();
  std::replace(words.begin(), words.end(), works.out().string(), part);
  ASSERT_EQ(test::run_program(words).exit_code, 0);
  words = works.run_words(true);
  words.insert(words.end(), {"--take", part});
  kill_anywhere(works, words, 1U + 3U * 4U);
  std::vector<json> taken = works.records();
  std::vector<json> theirs = read_records(part + "/records.jsonl");
  const json sittings = json::parse(test::bytes_of(works.out() / "provenance.json")).at("sittings");
  for (std::vector<json>* records : {&taken, &theirs}) {
    for (json& record : *records) record.erase("sitting");
  }
  EXPECT_THAT(taken, testing::UnorderedElementsAreArray(theirs)) << "times and all: nothing was run anew";
  EXPECT_EQ(
      std::count_if(sittings.begin(), sittings.end(), [](const json& one) { return one.contains("node"); }),
      1);
}

TEST(Faults, TwoRunsOnOneFolder) {
  const HostileContestant works(works_for("3600"));
  works.plan();
  StartedProgram first(works.run_words());
  ASSERT_TRUE(test::appears(works.folder() / "hostile/started")) << first.error();
  const std::string before = test::bytes_of(works.out() / "records.jsonl");
  const test::ProgramResult second = test::run_program(works.run_words(true));
  EXPECT_EQ(second.exit_code, 2);
  EXPECT_EQ(second.error, "palpate: " + works.out().string() + ": another run is at work in this folder\n");
  EXPECT_GE(works.processes().size(), 3U) << "the first goes on";
  EXPECT_EQ(test::bytes_of(works.out() / "records.jsonl"), before);
  first.signal(SIGINT);
  EXPECT_EQ(first.wait(), 130);
}

TEST(Faults, FailuresAreRunAnewIfAsked) {
  const HostileContestant once(
      "if not os.path.exists(here + '/again'):\n    open(here + '/again', 'w').write('')\n    sys.exit(7)\n"
      "answer_well()\n");
  once.plan("{repeats: 2}");
  const test::ProgramResult first = test::run_program(once.run_words());
  EXPECT_EQ(first.exit_code, 3) << first.error;
  EXPECT_THAT(outcomes(once).at("cube/hostile"), testing::ElementsAre("crashed", "accepted"));
  EXPECT_EQ(test::run_program(once.run_words(true)).exit_code, 3) << "a record is a record";
  const std::vector<json> before = once.records();
  std::vector<std::string> words = once.run_words(true);
  words.emplace_back("--retry-failed");
  const test::ProgramResult retried = test::run_program(words);
  EXPECT_EQ(retried.exit_code, 0) << retried.error;
  EXPECT_THAT(retried.error, HasSubstr("1 failed repeats are run anew"));
  EXPECT_THAT(outcomes(once).at("cube/hostile"), testing::UnorderedElementsAre("accepted", "accepted"));
  const std::vector<json> after = once.records();
  ASSERT_EQ(after.size(), before.size());
  std::size_t kept = 0;
  for (const json& record : before) kept += std::count(after.begin(), after.end(), record);
  EXPECT_EQ(kept, before.size() - 1) << "the others stay as they were, to the byte of their times";
  const std::vector<json> aside = read_records(once.out() / "retried.jsonl");
  ASSERT_EQ(aside.size(), 1U);
  EXPECT_EQ(aside[0].at("outcome"), "crashed");
  EXPECT_EQ(json::parse(test::bytes_of(once.out() / "provenance.json")).at("sittings").back().at("retried"),
            1);
  words.erase(std::find(words.begin(), words.end(), "--resume"));
  const test::ProgramResult alone = test::run_program(words);
  EXPECT_EQ(alone.exit_code, 2);
  EXPECT_THAT(alone.error, HasSubstr("--retry-failed"));
}

TEST(Faults, AFolderThatNobodyCanWriteIsSaid) {
  const HostileContestant works("answer_well()\n");
  works.plan();
  std::vector<std::string> words = works.run_words();
  std::replace(words.begin(), words.end(), works.out().string(), std::string("/proc/palpate"));
  const test::ProgramResult result = test::run_program(words);  // read-only for root too
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.error, HasSubstr("/proc/palpate: expected a folder that can be written"));
  EXPECT_EQ(std::count(result.error.begin(), result.error.end(), '\n'), 1);
}

/// Runs `work` in a mount namespace of its own with a file system of `size` (as mount takes it) at `place`.
/// Returns: what it returned, or nothing where the system allows no such namespace.
std::optional<int> with_small_disk(const fs::path& place, const std::string& size,
                                   const std::function<int()>& work) {
  constexpr int kNotAllowed = 77;
  const auto user = static_cast<unsigned>(::getuid());
  const pid_t child = ::fork();
  if (child == 0) {
    const auto write_map = [](const char* file, const std::string& text) {
      const int map = ::open(file, O_WRONLY | O_CLOEXEC);
      const bool done = ::write(map, text.data(), text.size()) == static_cast<ssize_t>(text.size());
      ::close(map);
      return done;
    };
    const bool is_mapped = user == 0
                               ? ::unshare(CLONE_NEWNS) == 0
                               : ::unshare(CLONE_NEWUSER | CLONE_NEWNS) == 0 &&
                                     write_map("/proc/self/uid_map", "0 " + std::to_string(user) + " 1");
    const bool is_ready = is_mapped && ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
                          ::mount("tmpfs", place.c_str(), "tmpfs", 0, ("size=" + size).c_str()) == 0;
    ::_exit(is_ready ? work() : kNotAllowed);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  if (WIFEXITED(status) && WEXITSTATUS(status) == kNotAllowed) return std::nullopt;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// Runs the plan on a disk of 64 MiB of which `left` stays free, twice, and a third time with room. The disk
/// is gone with its namespace: what is to be looked at is written to `folder`.
std::optional<int> run_on_full_disk(const HostileContestant& contestant, std::uint64_t left) {
  fs::create_directory(contestant.out());
  const auto note = [&](const char* name, const std::string& text) { contestant.folder().add(name, text); };
  return with_small_disk(contestant.out(), "64m", [&] {
    const fs::path ballast = contestant.out() / ".lock";  // a run's folder may hold a lock and nothing else
    const std::uint64_t size = fs::space(contestant.out()).available - left;
    const int file = ::open(ballast.c_str(), O_WRONLY | O_CREAT, 0644);
    if (::posix_fallocate(file, 0, static_cast<off_t>(size)) != 0) return 78;
    ::close(file);
    for (const char* name : {"first", "again"}) {
      const test::ProgramResult result = test::run_program(contestant.run_words(true));
      note(name, std::to_string(result.exit_code) + " " + result.error);
    }
    note("records_before", test::bytes_of(contestant.out() / "records.jsonl"));
    if (::truncate(ballast.c_str(), 0) != 0) return 79;
    const test::ProgramResult result = test::run_program(contestant.run_words(true));
    note("with_room", std::to_string(result.exit_code) + " " + result.error);
    note("records_after", test::bytes_of(contestant.out() / "records.jsonl"));
    return 0;
  });
}

void expect_nobody_blamed(const HostileContestant& contestant) {
  for (const char* name : {"first", "again"}) {
    const std::string said = test::bytes_of(contestant.folder() / name);
    EXPECT_THAT(said, testing::StartsWith("3 ")) << "something needed could not run";
    EXPECT_THAT(said, testing::AnyOf(HasSubstr("expected room"), HasSubstr("No space left on device")));
  }
  for (const json& record : read_records(contestant.folder() / "records_before"))
    EXPECT_EQ(record.at("outcome"), "accepted") << record.dump();
  EXPECT_THAT(test::bytes_of(contestant.folder() / "with_room"), testing::StartsWith("0 "));
  const std::vector<json> after = read_records(contestant.folder() / "records_after");
  EXPECT_EQ(after.size(), 4U);
  for (const json& record : after) EXPECT_EQ(record.at("outcome"), "accepted") << record.dump();
}

TEST(Faults, AFullDiskIsNobodysAnswer) {
  // Writes 8 MiB beside its answer, as a large mesh would be, and dies where there is no room for them.
  const HostileContestant writer("open(scratch + '/large', 'wb').write(b'x' * (8 << 20))\nanswer_well()\n");
  writer.plan();
  const auto done = run_on_full_disk(writer, std::uint64_t{4} << 20U);
  if (!done) GTEST_SKIP() << "no mounts of its own: user namespaces are not allowed here";
  ASSERT_EQ(*done, 0);
  expect_nobody_blamed(writer);
}

TEST(Faults, AnAnswerThatSaysThatTheDiskIsFullIsNobodys) {
  // Takes its file back before it says so, as AtomicFile does: there is room again when the runner looks.
  const HostileContestant writer(R"(
try:
    open(scratch + '/large', 'wb').write(b'x' * (40 << 20))
except OSError as error:
    os.remove(scratch + '/large')
    answer_with(json.dumps({"schema": "palpate/response/1", "status": "bad_input", "message": str(error)}))
    sys.exit(2)
answer_well()
)");
  writer.plan();
  const auto done = run_on_full_disk(writer, std::uint64_t{30} << 20U);
  if (!done) GTEST_SKIP() << "no mounts of its own: user namespaces are not allowed here";
  ASSERT_EQ(*done, 0);
  expect_nobody_blamed(writer);
}

TEST(Faults, AFullFolderOfTemporaryFilesIsNobodysAnswer) {
  const HostileContestant writer(
      "import tempfile\nopen(tempfile.gettempdir() + '/large', 'wb').write(b'x' * (8 << "
      "20))\nanswer_well()\n");
  writer.plan();
  const fs::path temporary = writer.folder() / "temporary";
  fs::create_directory(temporary);
  const auto done = with_small_disk(temporary, "12m", [&] {
    ::setenv("TMPDIR", temporary.c_str(), 1);
    const fs::path ballast = temporary / "ballast";
    const int file = ::open(ballast.c_str(), O_WRONLY | O_CREAT, 0644);
    if (::posix_fallocate(file, 0, off_t{10} << 20U) != 0) return 78;
    ::close(file);
    const test::ProgramResult full = test::run_program(writer.run_words(true));
    writer.folder().add("full", std::to_string(full.exit_code) + " " + full.error);
    fs::remove(ballast);
    const test::ProgramResult result = test::run_program(writer.run_words(true));
    writer.folder().add("with_room", std::to_string(result.exit_code) + " " + result.error);
    return 0;
  });
  if (!done) GTEST_SKIP() << "no mounts of its own: user namespaces are not allowed here";
  ASSERT_EQ(*done, 0);
  const std::string said = test::bytes_of(writer.folder() / "full");
  EXPECT_THAT(said, testing::StartsWith("3 "));
  EXPECT_THAT(said, HasSubstr(temporary.string() + ": expected room on the disk"));
  EXPECT_THAT(test::bytes_of(writer.folder() / "with_room"), testing::StartsWith("0 "));
  for (const json& record : writer.records()) EXPECT_EQ(record.at("outcome"), "accepted") << record.dump();
}

TEST(Faults, ALinkInARunsFolderIsRefused) {
  const HostileContestant works("answer_well()\n");
  works.plan();
  ASSERT_EQ(test::run_program(works.run_words()).exit_code, 0);
  fs::create_directory(works.folder() / "elsewhere");
  works.folder().add("elsewhere/theirs", "x");
  fs::remove_all(works.out() / "tables");
  fs::create_directory_symlink(works.folder() / "elsewhere", works.out() / "tables");
  const test::ProgramResult result = test::run_program(works.run_words(true));
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.error, HasSubstr("tables: expected a run's own file or folder, found a link"));
  EXPECT_EQ(test::bytes_of(works.folder() / "elsewhere/theirs"), "x");
}

TEST(Faults, ALinkDeeperInARunsFolderIsRefusedToo) {
  const HostileContestant works("answer_well()\n");
  works.plan();
  ASSERT_EQ(test::run_program(works.run_words()).exit_code, 0);
  works.folder().add("theirs", "x");
  fs::create_directory(works.folder() / "elsewhere");
  fs::create_directories(works.out() / ".parts");
  const fs::path output = works.out() / works.records().back().at("mesh_file").get<std::string>();
  ASSERT_TRUE(fs::exists(output));
  for (const fs::path& place : {output, works.out() / ".parts/0.log", works.out() / "problems"}) {
    fs::remove(place);
    fs::create_symlink(works.folder() / "theirs", place);
    const test::ProgramResult result = test::run_program(works.run_words(true));
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_THAT(result.error,
                HasSubstr(place.filename().string() + ": expected a run's own file or folder, found a link"));
    fs::remove(place);
  }
  fs::create_directory_symlink(works.folder() / "elsewhere", works.out() / ".parts/0");
  EXPECT_EQ(test::run_program(works.run_words(true)).exit_code, 2);
  fs::remove(works.out() / ".parts/0");
  fs::create_symlink(works.folder() / "nothing", works.out() / ".lock.link");
  fs::rename(works.out() / ".lock.link", works.out() / ".lock");
  EXPECT_EQ(test::run_program(works.run_words(true)).exit_code, 2);
  EXPECT_FALSE(fs::exists(works.folder() / "nothing"));
  EXPECT_TRUE(fs::is_empty(works.folder() / "elsewhere"));
  EXPECT_EQ(test::bytes_of(works.folder() / "theirs"), "x");
}

TEST(Faults, TooFewNumbersForFilesAreNobodysAnswer) {
  // It asks through a pipe whether memory can be read, and takes a pipe that it cannot open for a no.
  if (kIsSanitized) GTEST_SKIP() << "UndefinedBehaviorSanitizer itself needs numbers for files";
  const HostileContestant works("answer_well()\n");
  works.plan();
  std::vector<std::string> words{"/bin/sh", "-c", "ulimit -n $0; exec \"$@\"", "",
                                 program_folder() + "/palpate"};
  for (const std::string& word : works.run_words()) words.push_back(word);
  for (int most = 6; most < 20;
       ++most) {  // where it is too few to begin, too few for palpate_child, and enough
    SCOPED_TRACE(most);
    fs::remove_all(works.out());
    ProcessSpec spec;
    spec.arguments = words;
    spec.arguments[3] = std::to_string(most);
    spec.standard_error = works.folder() / "error";
    const ProcessResult result = run_process(spec);
    EXPECT_THAT(result.exit_code, testing::AnyOf(0, 2, 3)) << test::bytes_of(works.folder() / "error");
    if (!fs::exists(works.out() / "records.jsonl")) continue;
    for (const json& record : works.records()) EXPECT_EQ(record.at("outcome"), "accepted") << record.dump();
  }
}

TEST(Faults, WhoCriesDiskFullWithoutReasonIsToBlame) {
  const HostileContestant crier(
      "answer_with(json.dumps({'schema': 'palpate/response/1', 'status': 'bad_input', 'message': 'No space "
      "left on device'}))\nsys.exit(2)\n");
  if (fs::space(crier.folder().path()).available < std::uint64_t{5} << 30U)
    GTEST_SKIP() << "the disk of temporary files is nearly full indeed";
  EXPECT_EQ(crier.answer().outcome, "bad_input");
}

}  // namespace
}  // namespace palpate::experiments

// Contestants that leave processes behind, hand in what is no file, or take more than there is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>

#include "core/base/error.h"
#include "experiments/processes/child/sanitizers.h"
#include "tests/support/hostile_contestant.h"

namespace palpate::experiments {
namespace {

namespace fs = std::filesystem;
using test::HostileContestant;
using testing::HasSubstr;
using testing::Not;

/// A child that leaves its parent, its group and its session, ignores what can be ignored, and stays.
constexpr const char* kLeaves = R"(
def leave_for_good():
    if os.fork() == 0:
        os.setsid()
        if os.fork() == 0:
            os.setsid()
            for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGQUIT):
                signal.signal(number, signal.SIG_IGN)
            open(here + "/left", "w").write(str(os.getpid()))
            time.sleep(3600)
        time.sleep(3600)
    while not os.path.exists(here + "/left"):
        time.sleep(0.01)

leave_for_good()
)";

TEST(HostileContestant, TheFixtureSeesWhatIsLeft) {
  const HostileContestant sleeper("time.sleep(3600)\n");
  std::vector<std::string> words{"/usr/bin/python3", "-B",
                                 (sleeper.folder() / "hostile/adapter.py").string()};
  EXPECT_TRUE(sleeper.processes().empty());
  const pid_t child = ::fork();
  if (child == 0) {
    // A program that starts no other: one on its way to an exec has its parent's command line.
    ::execl("/usr/bin/python3", "python3", "-c", "import time; time.sleep(3600)", words[2].c_str(), nullptr);
    ::_exit(127);
  }
  for (int i = 0; i < 1000 && sleeper.processes().empty(); ++i) ::usleep(10'000);
  EXPECT_THAT(sleeper.processes(), testing::ElementsAre(child));
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  EXPECT_TRUE(sleeper.processes().empty());
}

TEST(HostileContestant, WhatLeftItsSessionEndsWithIt) {
  const HostileContestant leaver(std::string(kLeaves) + "answer_well()\n");
  const ContestantAnswer answer = leaver.answer();
  EXPECT_EQ(answer.outcome, "ok") << answer.message;
  EXPECT_TRUE(fs::exists(leaver.folder() / "hostile/left"));
  EXPECT_TRUE(leaver.processes().empty()) << "no signal is on its way any more: they were waited for";
}

TEST(HostileContestant, WhatLeftItsSessionEndsAtTheTimeOut) {
  const HostileContestant leaver(std::string(kLeaves) + "time.sleep(3600)\n");
  EXPECT_EQ(leaver.answer_with("left").outcome, "timed_out");
  EXPECT_TRUE(fs::exists(leaver.folder() / "hostile/left"));
  EXPECT_TRUE(leaver.processes().empty());
}

TEST(HostileContestant, AStormOfForksEnds) {
  const HostileContestant storm(R"(
signal.signal(signal.SIGTERM, signal.SIG_IGN)
open(here + "/storm", "w").write("")
for i in range(50):
    if os.fork() == 0:
        os.setsid()
        for each in range(100000):  # starts another and goes on with it; has an end, for the sake of the machine
            if os.fork() > 0:
                os._exit(0)
            time.sleep(0.002)
        os._exit(0)
time.sleep(3600)
)");
  const ContestantAnswer answer = storm.answer_with("storm", 4.0);
  EXPECT_EQ(answer.outcome, "timed_out");
  EXPECT_THAT(answer.message, Not(HasSubstr("could not be ended")));
  EXPECT_TRUE(fs::exists(storm.folder() / "hostile/storm"));
  EXPECT_TRUE(storm.all_end());
}

TEST(HostileContestant, AStormThatLeavesItsGroupsEnds) {
  const HostileContestant storm(R"(
for i in range(20):
    if os.fork() == 0:
        for each in range(100000):  # has an end, for the sake of the machine
            if os.fork() > 0:
                os._exit(0)
            os.setsid()
        os._exit(0)
)");
  const ContestantAnswer answer = storm.answer(3.0);
  EXPECT_THAT(answer.message, Not(HasSubstr("could not be ended")));
  EXPECT_TRUE(storm.all_end());
}

TEST(HostileContestant, WhoseFirstThreadHasEndedIsFoundToo) {
  const HostileContestant threads(R"(
import ctypes, threading
if os.fork() == 0:
    os.setsid()
    threading.Thread(target=time.sleep, args=(3600,)).start()
    open(here + "/left", "w").write("")
    ctypes.CDLL(None).syscall(60, 0)  # exit of this thread alone: the process is shown as a zombie
time.sleep(3600)
)");
  const ContestantAnswer answer = threads.answer_with("left");
  EXPECT_EQ(answer.outcome, "timed_out");
  EXPECT_THAT(answer.message, Not(HasSubstr("could not be ended")));
  EXPECT_TRUE(fs::exists(threads.folder() / "hostile/left"));
}

TEST(HostileContestant, TheSupervisorThatWasStoppedIsHelped) {
  const HostileContestant stopper(std::string(kLeaves) +
                                  "os.kill(os.getppid(), signal.SIGSTOP)\ntime.sleep(3600)\n");
  EXPECT_EQ(stopper.answer_with("left").outcome, "timed_out");
  EXPECT_TRUE(fs::exists(stopper.folder() / "hostile/left"));
  EXPECT_TRUE(stopper.all_end());
}

TEST(HostileContestant, AFloodKeepsItsEndAndLittleElse) {
  const HostileContestant flood(R"(
for i in range(100):
    os.write(2, b"x" * (1 << 20))
    os.write(1, b"y" * (1 << 20))
    time.sleep(0.01)
os.write(2, b"\nthe end\n")
sys.exit(9)
)");
  const ContestantAnswer answer = flood.answer();
  EXPECT_EQ(answer.outcome, "crashed");
  EXPECT_THAT(answer.message, HasSubstr("exit code 9 without an answer"));
  EXPECT_THAT(answer.message, testing::EndsWith("the end"));
  EXPECT_LE(answer.standard_error.size(), 4096U);
  EXPECT_LT(fs::file_size(flood.folder() / "scratch/stderr.txt"), std::uint64_t{17} << 20U);
}

/// What stands where a file should be, and what is said of it.
struct NoFile {
  const char* name;
  const char* program;
  const char* message;
};

void PrintTo(const NoFile& tested, std::ostream* out) {
  *out << tested.name;
}

class NoFiles : public testing::TestWithParam<NoFile> {};

TEST_P(NoFiles, AreNoAnswer) {
  const HostileContestant hostile(GetParam().program);
  hostile.folder().add("hostile/secret", "MeshVersionFormatted 2 the secret\n");
  const ContestantAnswer answer = hostile.answer();
  EXPECT_EQ(answer.outcome, "bad_answer");
  EXPECT_THAT(answer.message, HasSubstr(GetParam().message));
  EXPECT_THAT(answer.message + answer.standard_error, testing::Not(HasSubstr("the secret")));
}

const NoFile kNoFiles[] = {
    {"link", "os.symlink(here + '/secret', request['mesh_out'])\nanswer_well()\n", "its mesh is a link"},
    {"dangling", "os.symlink('/no/such/file', request['mesh_out'])\nanswer_well()\n", "its mesh is a link"},
    {"pipe", "os.mkfifo(request['mesh_out'])\nanswer_well()\n", "its mesh is a pipe"},
    {"hard_link", "os.link(here + '/secret', request['mesh_out'])\nanswer_well()\n",
     "its mesh is a file that has another name too"},
    {"folder", "os.mkdir(request['mesh_out'])\nanswer_well()\n", "its mesh is a folder"},
    {"device", "os.symlink('/dev/zero', request['mesh_out'])\nanswer_well()\n", "its mesh is a link"},
    {"socket",
     "os.chdir(scratch)\nsocket.socket(socket.AF_UNIX).bind(os.path.basename(request['mesh_out']))\n"
     "answer_well()\n",
     "its mesh is a socket"},
    {"answer_link", "os.symlink(here + '/secret', response)\n", "its answer is a link"},
    {"answer_pipe", "os.mkfifo(response)\n", "its answer is a pipe"},
    {"answer_hard_link", "os.link(here + '/secret', response)\n",
     "its answer is a file that has another name"},
    {"answer_folder", "os.mkdir(response)\n", "its answer is a folder"},
    {"answer_device", "os.symlink('/dev/zero', response)\n", "its answer is a link"},
    {"half", "answer_with('{\"schema\": \"palpate/resp')\n", "its answer: expected JSON"},
    {"deep", "answer_with('{\"report\":' + '[' * 100000 + ']' * 100000 + '}')\n",
     "expected at most 32 levels of nesting"},
    {"huge", "answer_with(' ' * (17 << 20))\n", "where 16777216 are the most"},
    {"long_in_a_record",
     "answer_with('{\"schema\": \"palpate/response/1\", \"status\": \"ok\", \"kernel_s\": 1, \"report\": "
     "{\"x\": [' + '9e14,' * 1000000 + '0]}}')\n",
     "bytes in a record, where 12582912 are the most"},
    {"other_case", "answer_well(**{'case': 'cube/good'})\n", "unknown key \"case\""},
    {"nan", "answer_well(**{'report': {'x': float('nan')}})\n", "expected a number, found NaN"},
    {"own_folder",
     "answer_well()\nos.rename(scratch, here + '/moved')\nos.symlink(here + '/moved', scratch)\n",
     "in the place of its folder"},
    {"input_link",
     "place = request['mesh_in']\nanswer_well()\nos.chmod(os.path.dirname(place), 0o700)\nos.remove(place)\n"
     "os.symlink(here + '/secret', place)\n",
     "it changed its input cube.mesh"},
};

std::string no_file_name(const testing::TestParamInfo<NoFile>& tested) {
  return tested.param.name;
}

INSTANTIATE_TEST_SUITE_P(All, NoFiles, testing::ValuesIn(kNoFiles), no_file_name);

TEST(HostileContestant, ALinkedErrorFileIsNotRead) {
  const HostileContestant hostile(
      "os.remove(scratch + '/stderr.txt')\nos.symlink(here + '/secret', scratch + '/stderr.txt')\n");
  hostile.folder().add("hostile/secret", "the secret\n");
  const ContestantAnswer answer = hostile.answer();
  EXPECT_EQ(answer.outcome, "crashed");
  EXPECT_THAT(answer.message + answer.standard_error, testing::Not(HasSubstr("the secret")));
}

TEST(HostileContestant, AnErrorFileWithAnotherNameIsNotRead) {
  const HostileContestant hostile(
      "os.remove(scratch + '/stderr.txt')\nos.link(here + '/secret', scratch + '/stderr.txt')\n");
  hostile.folder().add("hostile/secret", "the secret\n");
  const ContestantAnswer answer = hostile.answer();
  EXPECT_EQ(answer.outcome, "crashed");
  EXPECT_THAT(answer.message + answer.standard_error, testing::Not(HasSubstr("the secret")));
}

TEST(HostileContestant, AnOutputWithoutEndIsCutOff) {
  const HostileContestant sparse("open(request['mesh_out'], 'wb').truncate(50 << 30)\nanswer_well()\n");
  const ContestantAnswer answer = sparse.answer();
  EXPECT_EQ(answer.outcome, "crashed") << "no file may be that large";
  EXPECT_THAT(answer.message, HasSubstr("File too large"));
}

TEST(HostileContestant, MemoryIsCountedOverAllOfIt) {
  if (kIsSanitized) GTEST_SKIP() << "AddressSanitizer leaves no room for a bound";
  const HostileContestant many(R"(
for i in range(8):
    if os.fork() == 0:
        os.setsid()
        held = bytearray(os.urandom(1 << 20)) * 100
        open(here + "/held%d" % i, "w").write("")
        time.sleep(3600)
while not all(os.path.exists(here + "/held%d" % i) for i in range(8)):
    time.sleep(0.01)
time.sleep(3600)
)");
  const ContestantAnswer answer = many.answer(60.0, 512);  // 8 times 100 MiB, none of them near 512
  EXPECT_EQ(answer.outcome, "out_of_memory");
  EXPECT_EQ(answer.message, "its processes together took more than 512 MiB");
  EXPECT_GT(answer.peak_rss_bytes.value_or(0), std::uint64_t{512} << 20U);
  EXPECT_TRUE(many.processes().empty());
}

TEST(HostileContestant, MemoryThatIsSharedCountsOnce) {
  if (kIsSanitized) GTEST_SKIP() << "AddressSanitizer leaves no room for a bound";
  const HostileContestant many(R"(
held = bytearray(os.urandom(1 << 20)) * 200
for i in range(4):
    if os.fork() == 0:
        time.sleep(1)
        os._exit(0)
for i in range(4):
    os.wait()
answer_well()
)");
  const ContestantAnswer answer = many.answer(60.0, 512);  // five times 200 MiB that are the same
  EXPECT_EQ(answer.outcome, "ok") << answer.message;
  EXPECT_GT(answer.peak_rss_bytes.value_or(0), std::uint64_t{200} << 20U);
  EXPECT_LT(answer.peak_rss_bytes.value_or(0), std::uint64_t{400} << 20U);
}

}  // namespace
}  // namespace palpate::experiments

#include "experiments/processes/process.h"

#include <gtest/gtest.h>
#include <sys/types.h>
#include <unistd.h>

#include <csignal>
#include <string>
#include <thread>
#include <vector>

#include "experiments/processes/child/sanitizers.h"
#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

ProcessSpec shell(const std::string& script) {
  ProcessSpec spec;
  spec.arguments = {"/bin/sh", "-c", script};
  return spec;
}

/// Whether a process is gone, or a zombie that its new parent has not collected yet.
bool is_dead(pid_t process) {
  const std::string status = test::bytes_of("/proc/" + std::to_string(process) + "/stat");
  return status.empty() || status.find(") Z") != std::string::npos || status.find(") X") != std::string::npos;
}

TEST(Process, ExitCodeAndOutput) {
  const test::ScratchFolder folder;
  ProcessSpec spec = shell("echo said; echo wrong >&2; exit 7");
  spec.standard_output = folder / "out";
  spec.standard_error = folder / "error";
  const ProcessResult result = run_process(spec);
  EXPECT_EQ(result.end, ProcessEnd::kExited);
  EXPECT_EQ(result.exit_code, 7);
  EXPECT_EQ(test::bytes_of(folder / "out"), "said\n");
  EXPECT_EQ(test::bytes_of(folder / "error"), "wrong\n");
}

TEST(Process, SignalIsNamed) {
  const ProcessResult result = run_process(shell("kill -SEGV $$"));
  EXPECT_EQ(result.end, ProcessEnd::kSignalled);
  EXPECT_EQ(result.signal, SIGSEGV);
  EXPECT_EQ(result.message.find("killed by signal 11"), 0U) << result.message;
}

TEST(Process, MissingProgramIsNotStarted) {
  ProcessSpec spec;
  spec.arguments = {"/no/such/program"};
  const ProcessResult result = run_process(spec);
  EXPECT_EQ(result.end, ProcessEnd::kNotStarted);
  EXPECT_NE(result.message.find("/no/such/program"), std::string::npos);
}

TEST(Process, TimeOutKillsGrandchildrenToo) {
  const test::ScratchFolder folder;
  ProcessSpec spec = shell("sleep 3600 & echo $! > " + (folder / "pid").string() + "; sleep 3600");
  spec.timeout_s = 1.0;
  const ProcessResult result = run_process(spec);
  EXPECT_EQ(result.end, ProcessEnd::kTimedOut);
  EXPECT_EQ(result.message, "timed out after 1 s");
  const pid_t grandchild = std::stoi(test::bytes_of(folder / "pid"));
  // The signal is sent, not yet delivered, when run_process returns.
  for (int i = 0; i < 1000 && !is_dead(grandchild); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_TRUE(is_dead(grandchild));
}

TEST(Process, WhatItWasStoppedForIsNoTimeOfTheChild) {
  const std::string own = std::to_string(::getpid());
  ProcessSpec spec = shell("kill -STOP " + own + "; sleep 6; kill -CONT " + own + "; exit 3");
  spec.timeout_s = 4.0;
  spec.while_waiting = [] {};
  const ProcessResult result = run_process(spec);
  EXPECT_EQ(result.end, ProcessEnd::kExited) << result.message;
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_GT(result.stopped_s, 3.0);
  EXPECT_GE(result.wall_s, result.stopped_s);
}

TEST(Process, StopFlagEndsIt) {
  volatile std::sig_atomic_t flag = 0;
  ProcessSpec spec = shell("sleep 3600");
  spec.stop_flag = &flag;
  std::thread raiser([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    flag = 1;
  });
  const ProcessResult result = run_process(spec);
  raiser.join();
  EXPECT_EQ(result.end, ProcessEnd::kInterrupted);
}

TEST(Process, PeakMemoryIsTheChildsOwn) {
  // 64 MiB held by the child, and 256 MiB by this process.
  const std::vector<char> ballast(std::size_t{256} << 20U, 'x');
  ProcessSpec spec = shell("x=0123456789abcdef; i=0; while [ $i -lt 22 ]; do x=$x$x; i=$((i + 1)); done");
  const ProcessResult large = run_process(spec);
  const ProcessResult small = run_process(shell("true"));
  ASSERT_TRUE(large.has_usage && small.has_usage);
  EXPECT_GT(large.peak_rss_bytes, std::uint64_t{60} << 20U);
  EXPECT_LT(large.peak_rss_bytes, std::uint64_t{200} << 20U);
  EXPECT_LT(small.peak_rss_bytes, std::uint64_t{32} << 20U);
  EXPECT_EQ(ballast.back(), 'x');
}

TEST(Process, MemoryBoundHolds) {
  if (kIsSanitized) GTEST_SKIP() << "AddressSanitizer leaves no room for a bound";
  ProcessSpec spec = shell("x=0123456789abcdef; while true; do x=$x$x; done");
  spec.memory_bytes = std::uint64_t{128} << 20U;
  spec.timeout_s = 60.0;
  const ProcessResult result = run_process(spec);
  EXPECT_NE(result.end, ProcessEnd::kTimedOut) << "the loop ends only where memory does";
  EXPECT_FALSE(result.end == ProcessEnd::kExited && result.exit_code == 0);
  EXPECT_LT(result.peak_rss_bytes, std::uint64_t{128} << 20U);
}

TEST(Process, NoStandardInputAndPlainLocale) {
  const test::ScratchFolder folder;
  ProcessSpec spec = shell("cat; echo $LC_ALL $OMP_NUM_THREADS");
  spec.threads = 3;
  spec.standard_output = folder / "out";
  run_process(spec);
  EXPECT_EQ(test::bytes_of(folder / "out"), "C 3\n");
}

}  // namespace
}  // namespace palpate::experiments

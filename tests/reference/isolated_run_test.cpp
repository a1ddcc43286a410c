// Work in a forked child: its mesh, its failures, its end.
#include "reference/simplifier_support/isolated_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <stdexcept>
#include <string>
#include <thread>

#include "core/base/error.h"
#include "core/mesh/shapes/shapes.h"

namespace palpate::reference {
namespace {

using testing::HasSubstr;

/// The message of the std::runtime_error that `work` ends in; empty if there is none.
std::string failure_of(const std::function<TimedMesh()>& work, double time_limit_s = 60.0) {
  try {
    run_isolated(work, time_limit_s);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST(IsolatedRun, MeshAndTimeComeBackWhole) {
  const TetMesh mesh = build_kuhn_cube(12, 0.2, 4);  // more than a pipe holds at once
  const TimedMesh result = run_isolated([&] { return TimedMesh{0.125, mesh}; }, 60.0);
  EXPECT_EQ(result.mesh, mesh);
  EXPECT_EQ(result.kernel_s, 0.125);
  EXPECT_EQ(run_isolated([] { return TimedMesh{}; }, 60.0).mesh, TetMesh{});
}

TEST(IsolatedRun, TheChildLeavesThisProcessAsItWas) {
  int touched = 0;
  const pid_t self = ::getpid();
  const TimedMesh result = run_isolated(
      [&] {
        touched = 1;
        return TimedMesh{::getpid() == self ? 0.0 : 1.0, {}};
      },
      60.0);
  EXPECT_EQ(touched, 0);
  EXPECT_EQ(result.kernel_s, 1.0);
}

TEST(IsolatedRun, ExceptionsKeepTheirKindAndFirstLine) {
  EXPECT_EQ(failure_of([]() -> TimedMesh { throw std::runtime_error("no tets\nat all"); }), "no tets");
  EXPECT_THROW(run_isolated([]() -> TimedMesh { throw InputError("not this"); }, 60.0), InputError);
  EXPECT_THAT(failure_of([]() -> TimedMesh { throw std::bad_alloc(); }), HasSubstr("bad_alloc"));
  EXPECT_THAT(failure_of([]() -> TimedMesh { throw 7; }), HasSubstr("unknown type"));
}

TEST(IsolatedRun, ACrashAndAHangAreMessages) {
  const auto crash = []() -> TimedMesh {
    std::signal(SIGSEGV, SIG_DFL);  // a sanitizer's handler would exit instead
    ::raise(SIGSEGV);
    return {};
  };
  EXPECT_EQ(failure_of(crash), "crashed by signal 11");
  const auto hang = []() -> TimedMesh {
    std::this_thread::sleep_for(std::chrono::hours(1));
    return {};
  };
  EXPECT_EQ(failure_of(hang, 1.0), "stopped after 1 s");
  EXPECT_EQ(failure_of([]() -> TimedMesh { ::_exit(0); }), "ended without a result");
}

TEST(RunProgram, ExitCodesAndPrograms) {
  EXPECT_EQ(run_program({"/bin/sh", "-c", "exit 3"}), 3);
  EXPECT_EQ(run_program({"/bin/true"}), 0);
  EXPECT_THROW(run_program({"/nowhere/at/all"}), std::runtime_error);
  EXPECT_THROW(run_program({"/bin/sh", "-c", "kill -9 $$"}), std::runtime_error);
}

}  // namespace
}  // namespace palpate::reference

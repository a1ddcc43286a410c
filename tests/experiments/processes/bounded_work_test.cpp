#include "experiments/processes/bounded_work.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "core/base/error.h"
#include "experiments/processes/child/sanitizers.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using testing::HasSubstr;

TEST(BoundedWork, BringsItsValueBackToTheBit) {
  const json value = {{"third", 1.0 / 3.0},
                      {"least", std::numeric_limits<double>::denorm_min()},
                      {"large", std::numeric_limits<std::uint64_t>::max()},
                      {"text", std::string(300'000, 'x')},
                      {"none", nullptr}};
  const WorkResult result = run_bounded([&] { return json(value); }, {});
  EXPECT_EQ(result.end, WorkEnd::kDone) << result.message;
  EXPECT_EQ(result.value, value);
}

TEST(BoundedWork, RunsInAnotherProcess) {
  int changed = 0;
  const WorkResult result = run_bounded(
      [&] {
        changed = 1;
        return json(::getpid());
      },
      {});
  EXPECT_NE(result.value, ::getpid());
  EXPECT_EQ(changed, 0);
}

TEST(BoundedWork, TimeOut) {
  WorkBounds bounds;
  bounds.timeout_s = 0.1;
  const WorkResult result = run_bounded(
      [] {
        std::this_thread::sleep_for(std::chrono::hours(1));
        return json();
      },
      bounds);
  EXPECT_EQ(result.end, WorkEnd::kTimedOut);
  EXPECT_EQ(result.message, "took longer than 0.1 s");
  EXPECT_TRUE(result.value.is_null());
}

TEST(BoundedWork, WhatItWasStoppedForIsNoTimeOfTheWork) {
  WorkBounds bounds;
  bounds.timeout_s = 4.0;
  const pid_t own = ::getpid();
  const WorkResult result = run_bounded(
      [own] {
        ::kill(own, SIGSTOP);
        std::this_thread::sleep_for(std::chrono::seconds(6));
        ::kill(own, SIGCONT);
        std::this_thread::sleep_for(std::chrono::milliseconds(500));
        return json(3);
      },
      bounds);
  EXPECT_EQ(result.end, WorkEnd::kDone) << result.message;
  EXPECT_EQ(result.value, 3);
}

TEST(BoundedWork, Memory) {
  if (kIsSanitized) GTEST_SKIP() << "AddressSanitizer leaves no room for a bound";
  WorkBounds bounds;
  bounds.memory_bytes = 64U << 20U;
  const auto take = [](std::size_t bytes) {
    return run_bounded([bytes] { return json(std::vector<char>(bytes, 'x').size()); },
                       {60.0, 64U << 20U, nullptr});
  };
  EXPECT_EQ(take(16U << 20U).end, WorkEnd::kDone);
  const WorkResult result = take(256U << 20U);
  EXPECT_EQ(result.end, WorkEnd::kOutOfMemory);
  EXPECT_EQ(result.message, "needed more than 64 MiB of memory");
}

TEST(BoundedWork, TheBoundHoldsWhereverTheHeapEnds) {
  if (kIsSanitized) GTEST_SKIP() << "AddressSanitizer leaves no room for a bound";
  constexpr std::size_t kBlock = 1024;      // less than what a reading of the size takes and gives back
  constexpr std::size_t kBlocks = 2 * 132;  // twice what the heap grows by
  std::vector<std::vector<char>> taken;
  for (std::size_t i = 0; i < kBlocks; ++i) {
    taken.emplace_back(kBlock, 'x');
    const WorkResult result = run_bounded([] { return json(std::vector<char>(256U << 20U, 'x').size()); },
                                          {60.0, 64U << 20U, nullptr});
    ASSERT_EQ(result.end, WorkEnd::kOutOfMemory) << "with " << taken.size() << " KiB taken";
  }
}

TEST(BoundedWork, ACrashIsAResult) {
  const WorkResult result = run_bounded(
      []() -> json {
        std::signal(SIGSEGV, SIG_DFL);
        ::raise(SIGSEGV);
        return {};
      },
      {});
  EXPECT_EQ(result.end, WorkEnd::kCrashed);
  EXPECT_EQ(result.message, "was ended by signal 11");
}

TEST(BoundedWork, IsGivenUpWhenTheFlagRises) {
  const volatile std::sig_atomic_t raised = 1;
  WorkBounds bounds;
  bounds.stop_flag = &raised;
  const WorkResult result = run_bounded(
      [] {
        std::this_thread::sleep_for(std::chrono::hours(1));
        return json();
      },
      bounds);
  EXPECT_EQ(result.end, WorkEnd::kInterrupted);
}

TEST(BoundedWork, ExceptionsKeepTheirKind) {
  const auto throwing = [](const auto& error) { return [error]() -> json { throw error; }; };
  try {
    run_bounded(throwing(InputError("a.mesh", 3, "a number", "none")), {});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("a.mesh:3: expected a number, found none"));
  }
  EXPECT_THROW(run_bounded(throwing(UnavailableError("no program")), {}), UnavailableError);
  EXPECT_THROW(run_bounded(throwing(ContractError("no")), {}), ContractError);
}

}  // namespace
}  // namespace palpate::experiments

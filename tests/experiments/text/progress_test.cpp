#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace {

/// What stands on standard error, which is no terminal here, once so much is done.
std::string said_of(double seconds_left) {
  testing::internal::CaptureStderr();
  Progress progress;
  progress.reach(1, seconds_left);
  return testing::internal::GetCapturedStderr();
}

TEST(Progress, SaysHowLongTheRestTakes) {
  EXPECT_EQ(said_of(90.0), "palpate: 1 of 0 done, about 1 min 30 s left\n");
}

TEST(Progress, SaysNoTimeThatNobodyKnows) {
  EXPECT_EQ(said_of(-1.0), "palpate: 1 of 0 done\n");
}

}  // namespace
}  // namespace palpate::experiments

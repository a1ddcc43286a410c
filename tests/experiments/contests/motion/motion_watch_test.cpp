// What a person is told while a motion is prepared and computed.
#include "experiments/contests/motion_watch.h"

#include <gmock/gmock.h>

#include <fstream>
#include <string>

#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(MotionWatch, SaysEachStageOnceThenTheSteps) {
  const test::ScratchFolder folder;
  const auto file = folder / "progress.json";
  const auto write = [&](const std::string& text) { std::ofstream(file) << text; };
  testing::internal::CaptureStderr();
  {
    MotionWatch watch(file);
    watch.look();  // nothing is there yet
    write(R"({"schema": "palpate/progress/1", "stage": "modes", "seconds": 0.0})");
    watch.look();
    watch.look();
    write(R"({"schema": "palpate/progress/2", "stage": "another version's", "seconds": 0.0})");
    watch.look();
    write(
        R"({"schema": "palpate/progress/1", "time_step_s": 0.001, "stable_step_s": null, "stable_by": "none_needed",
              "steps": 500, "steps_done": 100, "limiting": null, "seconds": 5.0})");
    watch.look();
  }
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_THAT(said, HasSubstr("modes\n"));
  EXPECT_EQ(said.find("modes"), said.rfind("modes"));
  EXPECT_THAT(said, HasSubstr("500 steps of 0.001 s\n"));
  EXPECT_THAT(said, HasSubstr("all steps will take about 25 s"));
  EXPECT_THAT(said, Not(HasSubstr("another")));
}

}  // namespace
}  // namespace palpate::experiments

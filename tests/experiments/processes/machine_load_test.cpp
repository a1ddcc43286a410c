#include "experiments/processes/machine_load.h"

#include <gtest/gtest.h>

#include <chrono>

#include "experiments/processes/process.h"

namespace palpate::experiments {
namespace {

TEST(MachineLoad, TicksOfAllProcessors) {
  // user nice system idle iowait irq softirq steal guest guest_nice: guests are in user already.
  const auto ticks = parse_processor_ticks("cpu  10 20 30 400 50 6 7 8 9 9");
  ASSERT_TRUE(ticks);
  EXPECT_EQ(ticks->all, 531.0);
  EXPECT_EQ(ticks->busy, 81.0);
  for (const char* bad :
       {"", "cpu0 1 2 3 4 5 6 7 8", "cpu 1 2 3", "cpu 1 2 3 x 5 6 7 8", "cpu 1 2 3 -4 5 6 7 8"})
    EXPECT_FALSE(parse_processor_ticks(bad)) << bad;
}

/// What a child of ours took is not others': it is counted in the same seconds on both sides.
TEST(MachineLoad, ChildrenAreOurOwn) {
  const LoadMeter meter;
  ProcessSpec spec;
  spec.arguments = {"/bin/sh", "-c", "i=0; while [ $i -lt 300000 ]; do i=$((i+1)); done"};
  const ProcessResult result = run_process(spec);
  ASSERT_TRUE(result.has_usage);
  const MachineLoad load = meter.read();
  ASSERT_TRUE(load.load_1min && load.processor_s && load.others_s);
  EXPECT_GE(*load.load_1min, 0.0);
  // Others took at most what was left, and no less than nothing but for the ticks: each of the eight fields
  // is cut to 10 ms at both ends.
  constexpr double kTicks = 8 * 0.01;
  EXPECT_LE(*load.others_s, *load.processor_s - (result.user_s + result.system_s) + kTicks);
  EXPECT_GE(*load.others_s, -kTicks);
}

}  // namespace
}  // namespace palpate::experiments

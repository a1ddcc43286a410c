// States of a motion for those who look at it: evenly spread, both ends among them, never more than fit.
#include "reference/door/motion_problem.h"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "tests/support/scratch_folder.h"

namespace palpate::reference {
namespace {

using nlohmann::json;

/// Rows of a motion of one second, `rows` of them after the first; returns what lies beside the history.
json states_of(std::size_t rows, std::size_t vertices, double last_m = 1.0) {
  const test::ScratchFolder folder;
  MotionStates states(1.0, vertices);
  for (std::size_t k = 0; k <= rows; ++k) {
    const double time_s = static_cast<double>(k) / static_cast<double>(rows);
    if (!states.is_due(time_s)) continue;
    states.add(time_s, std::vector<Vec3>(vertices, {time_s, 0.0, k == rows ? last_m : -time_s}));
  }
  states.write_beside(folder.path() / "history.csv");
  std::ifstream file(folder.path() / "states.json");
  return file ? json::parse(file) : json();
}

TEST(MotionStates, AreEvenlySpreadWithBothEnds) {
  const json written = states_of(1000, 3);
  EXPECT_EQ(written.at("schema"), "palpate/states/1");
  const json& states = written.at("states");
  ASSERT_EQ(states.size(), MotionStates::kMostStates);
  for (std::size_t k = 0; k < states.size(); ++k) {
    const double even_s = static_cast<double>(k) / static_cast<double>(states.size() - 1);
    EXPECT_GE(states[k].at("time_s").get<double>(), even_s - 1e-9);
    EXPECT_LE(states[k].at("time_s").get<double>(), even_s + 1e-3 + 1e-9);
  }
  EXPECT_EQ(states.back().at("time_s"), 1.0);
  EXPECT_EQ(states[1].at("displacement_m").size(), 9U);
  EXPECT_NEAR(states[1].at("displacement_m")[2].get<double>(), -states[1].at("time_s").get<double>(), 0.5e-9);
}

TEST(MotionStates, OfFewRowsAreAllOfThem) {
  EXPECT_EQ(states_of(7, 3).at("states").size(), 8U);
}

TEST(MotionStates, OfALargeBodyAreFewerAndOfAHugeOneNone) {
  const std::size_t half = MotionStates::kMostNumbers / 6;  // two states of so many vertices fill it
  EXPECT_EQ(states_of(100, half).at("states").size(), 2U);
  EXPECT_TRUE(states_of(100, half + 1).is_null());
}

TEST(MotionStates, ThatAreNotFiniteAreNotWritten) {
  EXPECT_TRUE(states_of(100, 3, std::numeric_limits<double>::infinity()).is_null());
}

TEST(MotionStates, RefuseAnotherNumberOfVertices) {
  MotionStates states(1.0, 3);
  EXPECT_THROW(states.add(0.0, std::vector<Vec3>(2)), ContractError);
}

}  // namespace
}  // namespace palpate::reference

// The files of the contest motion: what is written reads back, what makes no sense is refused.
#include "reference/door/motion_problem.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <limits>

#include "core/base/error.h"
#include "core/mesh/subdivision/refinement.h"
#include "tests/support/rod.h"
#include "tests/support/scratch_folder.h"

namespace palpate::reference {
namespace {

using nlohmann::json;
using test::Rod;
using testing::ElementsAre;
using testing::HasSubstr;

/// A rod with a force all the time and a pad that comes and goes.
Rod make_rod() {
  Rod rod(2);
  rod.hold_left();
  MotionLoad weight = rod.empty_load();
  weight.part.gravity_m_s2 = {0.0, 0.0, -9.81};
  MotionLoad pad = rod.pad(1e4, 1e-3);
  pad.profile = {{0.0, 0.05}, {0.0, 1.0}, true};
  pad.from_s = 0.02;
  pad.until_s = 0.15;
  rod.problem.loads = {weight, pad};
  rod.problem.damping_stiffness_s = 1e-3;
  rod.problem.damping_mass_per_s = 2.0;
  rod.problem.frequencies = 3;
  return rod;
}

TEST(MotionProblemFile, ReadsBackWhatItWrote) {
  const Rod rod = make_rod();
  const json written = motion_to_json(rod.problem);
  const MotionProblem read = motion_from_json(written, rod.mesh, "problem.json");
  EXPECT_EQ(motion_to_json(read), written);
  EXPECT_EQ(read.loads[1].until_s, 0.15);
  EXPECT_FALSE(read.loads[0].until_s);
  EXPECT_FALSE(read.loads[0].is_tool());
  EXPECT_TRUE(read.loads[1].is_tool());
}

TEST(MotionProblemFile, RefusesWhatMakesNoSense) {
  const Rod rod = make_rod();
  const json good = motion_to_json(rod.problem);
  const std::vector<std::pair<std::function<void(json&)>, std::string>> cases{
      {[](json& p) { p["schema"] = "palpate/problem/1"; }, "palpate/motion_problem/1"},
      {[](json& p) { p["speed"] = 1; }, "no key \"speed\""},
      {[](json& p) { p.erase("body"); }, "the key \"body\""},
      {[](json& p) { p["duration_s"] = 0.0; }, "a duration above 0"},
      {[](json& p) { p["duration_s"] = -1.0; }, "duration_s"},
      {[](json& p) { p["duration_s"] = nullptr; }, "duration_s"},
      {[](json& p) { p["samples"] = 0; }, "samples"},
      {[](json& p) { p["probes"] = {100000}; }, "probes"},
      {[](json& p) { p["probes"] = {-1}; }, "probes"},
      {[](json& p) { p["frequencies"] = -1; }, "frequencies"},
      {[](json& p) { p["damping"]["stiffness_s"] = -1e-3; }, "damping.stiffness_s"},
      {[](json& p) { p["damping"]["spring"] = 1e-3; }, "no key \"spring\""},
      {[](json& p) { p["loads"] = 3; }, "a list"},
      {[](json& p) { p["loads"][1]["until_s"] = 0.02; }, "a time after from_s"},
      {[](json& p) { p["loads"][1]["from_s"] = -0.1; }, "from_s"},
      {[](json& p) { p["loads"][1]["profile"]["shares"] = {0.0}; }, "as many times as shares"},
      {[](json& p) {
         p["loads"][1]["profile"]["times_s"] = {0.05, 0.0};
       },
       "times that increase"},
      {[](json& p) { p["loads"][1]["profile"]["smooth"] = 1; }, "true or false"},
      {[](json& p) { p["loads"][0]["part"]["material"]["poisson_ratio"] = 0.3; }, "the body's material"},
      {[](json& p) { p["loads"][0]["part"]["supports"] = 1; }, "loads[0]"},
  };
  for (const auto& [spoil, reason] : cases) {
    json bad = good;
    spoil(bad);
    try {
      motion_from_json(bad, rod.mesh, "problem.json");
      ADD_FAILURE() << "taken: " << reason;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("problem.json"));
      EXPECT_THAT(error.what(), HasSubstr(reason));
    }
  }
}

TEST(MotionProblemFile, PhasesBeginWhereLoadsComeAndGo) {
  const Rod rod = make_rod();
  const std::vector<LoadPhase> phases = find_phases(rod.problem);
  ASSERT_EQ(phases.size(), 3U);
  EXPECT_EQ(phases[1].from_s, 0.02);
  EXPECT_EQ(phases[1].to_s, 0.15);
  EXPECT_EQ(phases[2].to_s, 0.2);
  EXPECT_THAT(phases[0].loads, ElementsAre(0U));
  EXPECT_THAT(phases[1].loads, ElementsAre(0U, 1U));
  EXPECT_THAT(phases[2].loads, ElementsAre(0U));
}

TEST(MotionProblemFile, RefiningKeepsTheAreaOfThePad) {
  const Rod rod = make_rod();
  const TetMesh refined = refine_uniformly(rod.mesh);
  const MotionProblem made = refine_motion(rod.problem, rod.mesh, refined);
  EXPECT_EQ(made.loads[1].part.supports[0].patch.faces.size(), 4 * rod.right().size());
  EXPECT_EQ(made.probes, rod.problem.probes);
}

/// Reads a history from text.
class HistoryFile : public testing::Test {
 protected:
  MotionHistory read(const std::string& text) {
    std::ofstream(scratch_ / "history.csv") << text;
    return read_history(scratch_ / "history.csv", rod_.problem);
  }

  std::string header() const {
    std::string text;
    for (const std::string& name : history_columns(rod_.problem)) text += (text.empty() ? "" : ",") + name;
    return text + "\n";
  }

  void refused(const std::string& text, const std::string& reason) {
    try {
      read(text);
      ADD_FAILURE() << "taken: " << text;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(reason));
    }
  }

  test::ScratchFolder scratch_;
  Rod rod_ = make_rod();
};

TEST_F(HistoryFile, ReadsBackToTheBit) {
  MotionHistory history{history_columns(rod_.problem), {}};
  EXPECT_THAT(history.columns,
              ElementsAre("time_s", "kinetic_j", "elastic_j", "load_j", "total_j", "tool_2_fx_n",
                          "tool_2_fy_n", "tool_2_fz_n", "probe_1_ux_m", "probe_1_uy_m", "probe_1_uz_m"));
  for (const double time : {0.0, 0.1, 0.2}) {
    std::vector<double> row(history.columns.size(), 1.0 / 3.0);
    row[0] = time;
    history.rows.push_back(row);
  }
  write_history(scratch_ / "written.csv", history);
  const MotionHistory read = read_history(scratch_ / "written.csv", rod_.problem);
  EXPECT_EQ(read.rows, history.rows);
  history.rows[1][3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(write_history(scratch_ / "written.csv", history), ContractError);
}

TEST_F(HistoryFile, RefusesWhatIsNoHistory) {
  const std::string zeros = ",0,0,0,0,0,0,0,0,0,0\n";
  EXPECT_EQ(read(header() + "0" + zeros + "0.2" + zeros).rows.size(), 2U);
  refused("", "a history");
  refused("time_s,x\n", "kinetic_j");
  refused(header() + "0" + zeros, "its end");
  refused(header() + "0" + zeros + "0.1" + zeros, "a history to 0.2 s");
  refused(header() + "0.1" + zeros, "rising from 0");
  refused(header() + "0" + zeros + "0" + zeros, "rising from 0");
  refused(header() + "0" + zeros + "0.2,1\n", "11 finite numbers");
  refused(header() + "0" + zeros + "0.2,nan,0,0,0,0,0,0,0,0,0\n", "11 finite numbers");
  refused(header() + "0" + zeros + "0.2,1,0,0,0,0,0,0,0,0,0,0\n", "11 finite numbers");
}

}  // namespace
}  // namespace palpate::reference

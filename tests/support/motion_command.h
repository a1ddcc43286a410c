// palpate simulate on a body in motion, as a program.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/experiment_fixture.h"
#include "tests/support/scene_text.h"

namespace palpate::test {

/// Runs palpate simulate on scenes of a small cube.
class MotionCommand : public testing::Test {
 protected:
  /// Steps that most of its tests take.
  inline static const std::string kGood =
      "integrator: symplectic_euler, time_step_s: auto, duration_s: 0.1, damping: {stiffness_s: 0.001}";

  /// A cube that is held below and pressed from above, then let go.
  static SceneText pressed(const std::string& dynamic) {
    SceneText text;
    text.material = "{young_modulus_pa: 10000, poisson_ratio: 0.25, density_kg_m3: 1000}";
    text.clamp = "[{half_space: {normal: [0, 0, 1], offset_m: 0}}]";
    text.load =
        "[{displace: {half_space: {normal: [0, 0, -1], offset_m: -0.1}, by_m: [0, 0, -0.01]}, profile: "
        "{times_s: "
        "[0, 0.05], shares: [0, 1], smooth: true}, until_s: 0.06}]";
    text.analysis = "{dynamic: {" + dynamic + "}}";
    text.rest = "strain: large\nmodel: {springs: van_gelder}\n";
    return text;
  }

  std::string scene(const SceneText& text) const {
    return fixture_.folder().add("scene.yaml", text.yaml()).string();
  }
  std::string error_of(const SceneText& text) const {
    const auto result = run_program({"simulate", scene(text), "-o", (fixture_.folder() / "out").string()});
    EXPECT_EQ(result.exit_code, 2) << result.out;
    return result.error;
  }
  std::string error_of(const std::string& dynamic) const { return error_of(pressed(dynamic)); }

  nlohmann::json simulate(const SceneText& text, const std::string& folder, const std::string& threads = "1",
                          int exit_code = 0) const {
    const auto result = run_program({"simulate", scene(text), "-o", (fixture_.folder() / folder).string(),
                                     "--json", "--threads", threads});
    EXPECT_EQ(result.exit_code, exit_code) << result.error;
    return nlohmann::json::parse(result.out);
  }

  ExperimentFixture fixture_;
};

/// The cells of a file, row by row.
inline std::vector<std::vector<std::string>> read_csv(const std::filesystem::path& path) {
  std::istringstream lines(bytes_of(path));
  std::vector<std::vector<std::string>> rows;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream cells(line);
    std::vector<std::string>& row = rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(cell);
  }
  return rows;
}

}  // namespace palpate::test

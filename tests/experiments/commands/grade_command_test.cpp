// palpate grade as a program: from a scene to its mesh, and what it refuses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/mesh/io/medit.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "core/simplify/sizing/size_file.h"
#include "experiments/scene_reader/scene.h"
#include "tests/support/experiment_fixture.h"
#include "tests/support/scene_text.h"
#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using test::ProgramResult;
using test::run_program;
using testing::HasSubstr;

constexpr double kSideM = 0.1;

/// A cube of 10 cm on an elastic support, pressed by a pad in the middle of its top.
class GradeCommand : public testing::Test {
 protected:
  GradeCommand() {
    write_medit(folder_ / "cube.mesh", build_kuhn_cube(9, 0.15, 2));
    text_.clamp = "[{half_space: {normal: [0, 0, 1], offset_m: 0.001}, elastic_pa_per_m: 1.0e+6}]";
    text_.load =
        "[{displace: {sphere: {center_m: [0.05, 0.05, 0.1], radius_m: 0.02}, by_m: [0, 0, -0.002], "
        "elastic_pa_per_m: 5.0e+6}}]";
    text_.rest = "model: {smoothed: edge_node}\n";
  }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  ProgramResult grade(const std::string& out, const std::vector<std::string>& more) const {
    folder_.add("scene.yaml", text_.yaml());
    std::vector<std::string> words{"grade", path("scene.yaml"), "-o", path(out), "--json"};
    words.insert(words.end(), more.begin(), more.end());
    return run_program(words);
  }

  void expect_noted(const std::vector<std::string>& words, const std::string& part) const {
    const ProgramResult result = grade("noted", words);
    EXPECT_EQ(result.exit_code, 0) << result.error;
    EXPECT_THAT(result.error, HasSubstr(part));
    std::filesystem::remove_all(path("noted"));
  }

  void expect_refused(const std::vector<std::string>& words, const std::string& part) const {
    const ProgramResult result = grade("refused", words);
    EXPECT_EQ(result.exit_code, 2) << result.error;
    EXPECT_THAT(result.error, HasSubstr(part));
    EXPECT_FALSE(std::filesystem::exists(path("refused")));
  }

  /// Mean length of the edges near the pad over that of those far from it, but for edges of the skin.
  static double near_over_far(const TetMesh& mesh) {
    double near = 0.0;
    double near_count = 0.0;
    double far = 0.0;
    double far_count = 0.0;
    const std::vector<std::uint8_t> skin = build_boundary_vertex_flags(mesh);
    for (const auto& [a, b] : build_edges(mesh)) {
      if (skin[a] != 0 && skin[b] != 0) continue;
      const Vec3 middle = 0.5 * (mesh.points[a] + mesh.points[b]);
      const double distance = length(middle - Vec3{0.5 * kSideM, 0.5 * kSideM, kSideM});
      const double edge = length(mesh.points[b] - mesh.points[a]);
      if (distance < 0.03) {
        near += edge;
        near_count += 1.0;
      } else if (distance > 0.06) {
        far += edge;
        far_count += 1.0;
      }
    }
    return near / near_count / (far / far_count);
  }

  test::ScratchFolder folder_;
  test::SceneText text_;
};

TEST_F(GradeCommand, MakesAMeshThatIsFineNearThePadAndASceneOnIt) {
  const ProgramResult result =
      grade("graded", {"--ratio", "0.6", "--near", "loads", "--near-size", "0.4", "--reach", "0.06"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json report = json::parse(result.out);
  EXPECT_EQ(report.at("schema"), "palpate/grade/1");
  EXPECT_TRUE(report.at("valid"));
  const TetMesh whole = read_medit(path("graded/whole.mesh")).mesh;
  const TetMesh graded = read_medit(path("graded/organ.mesh")).mesh;
  EXPECT_EQ(report.at("tets"), graded.tets.size());
  EXPECT_NEAR(static_cast<double>(graded.tets.size()), 0.4 * static_cast<double>(whole.tets.size()),
              0.01 * static_cast<double>(whole.tets.size()));
  EXPECT_LT(near_over_far(graded),
            0.8);  // the mesh has none finer than a ninth of the cube; one size: above 0.9
  const ProgramResult even = grade("even", {"--ratio", "0.6"});
  ASSERT_EQ(even.exit_code, 0) << even.error;
  EXPECT_GT(near_over_far(read_medit(path("even/organ.mesh")).mesh), 0.9);
  // The sizes that were wanted are finest at the pad, and the scene is ready.
  const std::vector<double> sizes = simplify::read_sizes(path("graded/sizes.csv"), whole.points.size());
  const auto finest = std::min_element(sizes.begin(), sizes.end()) - sizes.begin();
  EXPECT_LT(length(whole.points[static_cast<std::size_t>(finest)] - Vec3{0.05, 0.05, 0.1}), 0.03);
  const ProgramResult checked = run_program({"check", path("graded/scene.yaml")});
  EXPECT_EQ(checked.exit_code, 0) << checked.error;
  const ProgramResult simulated =
      run_program({"simulate", path("graded/scene.yaml"), "-o", path("answer"), "--json"});
  ASSERT_EQ(simulated.exit_code, 0) << simulated.error;
  EXPECT_EQ(json::parse(simulated.out).at("tets"), graded.tets.size());
  EXPECT_EQ(read_scene(path("graded/scene.yaml")).mesh.regions_from.filename(), "whole.mesh");
}

TEST_F(GradeCommand, ACountThatIsNotReachedIsSaidWithWhatHeldIt) {
  const ProgramResult result = grade("short", {"--ratio", "0.99", "--near", "loads"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.error, HasSubstr("the count was not reached: "));
  EXPECT_THAT(result.error, HasSubstr("touch the skin of 972 faces, which was kept"));
  EXPECT_THAT(result.error, HasSubstr("--method palpate.surface"));
  const json report = json::parse(result.out);
  EXPECT_FALSE(report.at("reached"));
  EXPECT_EQ(report.at("shortfall").at("reached_tets"), report.at("tets"));
}

TEST_F(GradeCommand, APilotFindsThePadByItselfAndTheSameCommandGivesTheSameBytes) {
  const std::vector<std::string> words{"--ratio", "0.6", "--pilot", "smoothed.edge_node"};
  const ProgramResult once = grade("once", words);
  ASSERT_EQ(once.exit_code, 0) << once.error;
  EXPECT_GT(json::parse(once.out).at("pilot_s"), 0.0);
  EXPECT_LT(json::parse(once.out).at("least_wanted_size"), 1.0);
  const TetMesh graded = read_medit(path("once/organ.mesh")).mesh;
  EXPECT_LT(near_over_far(graded), 0.9);
  ASSERT_EQ(grade("again", words).exit_code, 0);
  EXPECT_EQ(read_medit(path("again/organ.mesh")).mesh.points, graded.points);
}

TEST_F(GradeCommand, AMovingSceneIsGradedAtRestAndByItsProbes) {
  text_.rest = "";
  text_.analysis =
      "{dynamic: {integrator: symplectic_euler, time_step_s: 1.0e-5, duration_s: 0.01, probes_m: [[0.05, "
      "0.05, "
      "0.1]]}}\nmodel: {smoothed: edge_node}\nstrain: large";
  const ProgramResult result = grade("moving", {"--ratio", "0.6", "--near", "probes", "--radius", "0.02"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_GT(json::parse(result.out).at("touched_vertices"), 1);
  EXPECT_LT(near_over_far(read_medit(path("moving/organ.mesh")).mesh), 0.9);
  EXPECT_EQ(run_program({"check", path("moving/scene.yaml")}).exit_code, 0);
}

TEST_F(GradeCommand, RefusesNonsenseAndLeavesNothing) {
  expect_refused({"--near", "loads"}, "one of --tets and --ratio");
  expect_refused({"--near", "loads", "--ratio", "0.5", "--tets", "100"}, "one of --tets and --ratio");
  expect_refused({"--ratio", "0.5", "--near", "probes"}, "a scene with probes, found none");
  expect_refused({"--ratio", "0.5", "--near", "forces"}, "a scene with forces, found none");
  expect_refused({"--ratio", "0.5", "--near", "tools"}, "loads");
  expect_refused({"--ratio", "0.5", "--near", "sphere 5 5 5 0.1"}, "meets no tetrahedron");
  expect_refused({"--ratio", "0.5", "--near", "sphere 0 0 0 nan"}, "finite number");
  expect_refused({"--ratio", "0.5", "--near", "sphere 0 0 0 -1"}, "radius");
  expect_refused({"--ratio", "0.5", "--near", "loads", "--near-size", "-0.5"}, "--near-size");
  expect_refused({"--ratio", "0.5", "--near", "loads", "--growth", "nan"}, "--growth");
  expect_refused({"--ratio", "0.5", "--pilot", "smoothed.edge_nod"}, "smoothed.edge_node");
  expect_refused({"--ratio", "0.5", "--pilot", "palpate.refined"}, "not in deform");
  expect_refused({"--ratio", "0.5", "--near", "loads", "--method", "palpate.outcome"}, "takes sizes");
  expect_refused({"--tets", "1000000", "--near", "loads"}, "fewer than the mesh has");
}

TEST_F(GradeCommand, SizesOfPlacesThatNobodyNamedAreSaid) {
  for (const char* flag : {"--near-size", "--radius", "--reach"})
    expect_noted({"--ratio", "0.1", flag, "0.5"}, std::string(flag) + " has no use without --near");
  expect_noted({"--ratio", "0.1", "--least-size", "0.5"}, "--least-size has no use without --pilot");
  expect_noted({"--ratio", "0.1", "--growth", "0.5"}, "--growth has no use without --near or --pilot");
  const ProgramResult used =
      grade("used", {"--ratio", "0.1", "--near", "pads", "--near-size", "0.5", "--growth", "0.5"});
  EXPECT_EQ(used.exit_code, 0) << used.error;
  EXPECT_THAT(used.error, testing::Not(HasSubstr("has no use")));
}

}  // namespace
}  // namespace palpate::experiments

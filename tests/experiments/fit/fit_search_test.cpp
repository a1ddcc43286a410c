// What a fit plans before it runs anything: the other loads take hold of the scene's own mesh.
#include "experiments/fit/fit_search.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "core/mesh/topology.h"
#include "experiments/scene_reader/scene_problem.h"
#include "tests/support/scene_text.h"
#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

class FitSearchPlan : public testing::Test {
 protected:
  FitSearchPlan() {
    text_.mesh = "{make: bar, vertices: 200, length_m: 0.1}";
    text_.clamp = "[{half_space: {normal: [1, 0, 0], share: 0.1}, elastic_pa_per_m: 1.0e+6}]";
    text_.rest = "require: {error: {measure: deformation_l2, at_most: 0.3}}\n";
  }

  /// A pad that holds the vertices of a sphere by themselves, of so many times the radius that the largest
  /// face takes.
  void press_a_face(double radii) {
    const TetMesh mesh = build_scene_mesh(read_scene(folder_.add("bar.yaml", text_.yaml())).mesh).mesh;
    double radius = 0.0;
    Vec3 center;
    for (const Triangle& face : build_boundary(mesh)) {
      const Vec3 a = mesh.points[face[0]];
      const Vec3 b = mesh.points[face[1]];
      const Vec3 c = mesh.points[face[2]];
      const Vec3 middle = (1.0 / 3.0) * (a + b + c);
      const double own = std::max({length(a - middle), length(b - middle), length(c - middle)});
      if (middle.x < 0.05 || own <= radius) continue;
      radius = own;
      center = middle;
    }
    const json sphere{{"center_m", {center.x, center.y, center.z}}, {"radius_m", radii * radius}};
    text_.load = "[{displace: {sphere: " + sphere.dump() + ", by_m: [0, -0.001, 0]}}]";
  }

  FitSearch plan(const std::vector<FitSimplifier>& simplifiers = {}) {
    const Scene scene = read_scene(folder_.add("scene.yaml", text_.yaml()));
    FitCandidates candidates;
    candidates.models.push_back({"edge_node", "smoothed.edge_node", json::object(), {{"first", {}}}});
    candidates.simplifiers = simplifiers;
    Progress progress(true);
    const std::filesystem::path out = folder_ / "fit";
    return plan_search({out, scene, FitWork::kFirst, 60.0, false, nullptr}, registry_, progress, candidates);
  }

  static json place(const json& scene) { return scene.at("/load/0/displace/sphere/center_m"_json_pointer); }
  static json way(const json& scene) { return scene.at("/load/0/displace/by_m"_json_pointer); }

  test::ScratchFolder folder_;
  test::SceneText text_;
  Registry registry_ = load_registry();
};

TEST_F(FitSearchPlan, APadThatWouldLoseItsOnlyFaceKeepsItsPlace) {
  press_a_face(1.01);
  const FitSearch found = plan();
  const json& own = found.plan.scenes.front();
  ASSERT_EQ(found.others.size(), kOtherLoads + kFurtherLoads);
  // A smaller move, of one within the range, may leave it its face.
  for (std::size_t k = 0; k < kOtherLoads; ++k) EXPECT_EQ(place(found.others[k]), place(own)) << k;
  for (const json& other : found.others) EXPECT_NE(way(other), way(own));
}

TEST_F(FitSearchPlan, APadOfManyFacesMoves) {
  press_a_face(4.0);
  const FitSearch found = plan();
  for (const json& other : found.others) EXPECT_NE(place(other), place(found.plan.scenes.front()));
}

TEST_F(FitSearchPlan, SkinsThatStrayAreTriedWhereTheSkinIsFine) {
  FitSimplifier strays;
  strays.label = "strays";
  strays.method = "palpate.surface";
  strays.ratios = {0.5};
  strays.skin_within = 0.01;
  const FitSearch fine = plan({strays});  // a bar of 200 vertices, most of them on its skin
  EXPECT_EQ(fine.plan.candidates.size(), 2U);
  EXPECT_THAT(fine.dropped, testing::IsEmpty());
  text_.mesh = "{make: bar, vertices: 8000, length_m: 0.1}";
  const FitSearch coarse = plan({strays});
  EXPECT_EQ(coarse.plan.candidates.size(), 1U);
  EXPECT_THAT(coarse.dropped, testing::ElementsAre(testing::HasSubstr("the skin is coarse")));
}

}  // namespace
}  // namespace palpate::experiments

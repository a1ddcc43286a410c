#include "experiments/judging/poor_skin.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"

namespace palpate::experiments {
namespace {

nlohmann::json skin_of(const TetMesh& mesh) {
  return describe_poor_skin(mesh, build_unpaired_faces(mesh));
}

TEST(PoorSkin, FacesAndEdgesAreNamed) {
  EXPECT_TRUE(skin_of(build_kuhn_cube(3, 0.0, 1)).is_null());
  TetMesh flat = build_kuhn_cube(3, 0.0, 1);
  for (Vec3& point : flat.points) point.x *= 0.02;
  const nlohmann::json skin = skin_of(flat);
  // Of right-angled triangles, sides 1 and 0.02: (sqrt(3) 0.02 / 1.0004)^(2/3). Two sides of the cube are
  // not.
  EXPECT_EQ(skin.at("faces").at("count"), 72);
  EXPECT_EQ(skin.at("edges").at("count"), 0);
  EXPECT_NEAR(skin.at("faces").at("worst").front().at("mean_ratio").get<double>(), 0.1062375, 1e-7);
  EXPECT_EQ(skin.at("faces").at("worst").size(), 10U);
  const TetMesh wedge{{{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {0.5, 1, 0.1}}, {{0, 1, 2, 3}}};
  const nlohmann::json edges = skin_of(wedge).at("edges");
  ASSERT_EQ(edges.at("count"), 1);
  const nlohmann::json& edge = edges.at("worst").front();
  EXPECT_EQ(edge.at("vertices"), nlohmann::json({1, 2}));
  EXPECT_EQ(edge.at("at"), nlohmann::json({0.5, 0.0, 0.0}));
  EXPECT_NEAR(edge.at("angle_deg").get<double>(), std::atan(0.1) * 180.0 / std::numbers::pi, 1e-9);
}

}  // namespace
}  // namespace palpate::experiments

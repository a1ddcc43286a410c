#include "experiments/judging/judge_record.h"

#include <gtest/gtest.h>

#include "tests/support/small_meshes.h"

namespace palpate::experiments {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

TEST(JudgeRecord, AnUnchangedSkinIsAtDistanceZero) {
  const TetMesh input = make_kuhn_block(3, 3, 3);
  TetMesh output = input;
  for (const Index v : interior_vertices_of_block(3, 3, 3)) output.points[v].x += 0.1;
  const auto figures = judge_output(output, input).figures;
  for (const char* key : {"surface_distance_lower", "surface_distance_upper", "surface_distance_relative",
                          "mean_surface_distance", "mean_surface_distance_error"}) {
    EXPECT_EQ(figures.at(key), 0.0) << key;
  }
  EXPECT_EQ(figures.at("boundary_bend_ratio"), 1.0);
  EXPECT_EQ(figures.at("surface_self_intersections"), 0);
}

TEST(JudgeRecord, AMovedSkinIsBracketed) {
  const TetMesh input = make_kuhn_block(3, 3, 3);
  TetMesh output = input;
  output.points[block_vertex(3, 3, 3, 3, 3)] = {3.25, 3.25, 3.25};
  const auto figures = judge_output(output, input).figures;
  const double exact = 0.25 * std::sqrt(3.0);  // of the corner that was pulled out
  EXPECT_NEAR(figures.at("surface_distance_lower").get<double>(), exact, 1e-12);
  EXPECT_GE(figures.at("surface_distance_upper").get<double>(), exact - 1e-12);
  EXPECT_LE(figures.at("surface_distance_upper").get<double>(), 1.02 * exact);
  EXPECT_GT(figures.at("mean_surface_distance").get<double>(), 0.0);
  EXPECT_GT(figures.at("boundary_bend_ratio").get<double>(), 1.0);
  EXPECT_NEAR(figures.at("surface_distance_relative").get<double>(), exact / std::sqrt(3.0 * 3.25 * 3.25),
              0.01);
}

TEST(JudgeRecord, AMeshWithoutTetsHasNoDistance) {
  const auto figures = judge_output({}, make_kuhn_block(1, 1, 1)).figures;
  EXPECT_TRUE(figures.at("surface_distance_upper").is_null());
  EXPECT_EQ(figures.at("null_reasons").at("surface_distance_upper"), "infinite");
  EXPECT_EQ(figures.at("null_reasons").at("boundary_bend_ratio"), "not a number");
}

TEST(JudgeRecord, GoodTetsThatOverlapAreCounted) {
  const TetMesh block = make_kuhn_block(2, 2, 2);
  const TetMesh twice = join_meshes(block, translated(block, {1.5, 0.25, 0.25}));
  const Judgement judgement = judge_mesh(twice);
  EXPECT_TRUE(judgement.validity.is_valid());
  EXPECT_GT(judgement.figures.at("surface_self_intersections"), 0);
}

}  // namespace
}  // namespace palpate::experiments

// palpate.surface on the organs: the judge verifies the bound that the user gives.
#include <gtest/gtest.h>

#include "core/simplify/surface/surface.h"
#include "experiments/judging/judge_record.h"
#include "experiments/meshes/mesh_source.h"

namespace palpate::experiments {
namespace {

TEST(OrganSurface, TheJudgeVerifiesEveryBound) {
  struct Case {
    const char* name;
    double unit;  ///< a thousandth of the organ's length, about
  };
  for (const Case& c : {Case{"kidney", 0.1}, Case{"liver", 0.2}, Case{"bean", 0.01}, Case{"ball", 0.002}}) {
    const TetMesh input = make_shape({.name = c.name}).mesh;
    for (const double factor : {0.0, 2.0, 10.0, 40.0}) {
      for (const bool to_limit : {false, true}) {
        SCOPED_TRACE(std::string(c.name) + " bound " + std::to_string(factor * c.unit));
        simplify::SurfaceOptions options;
        options.max_surface_error = factor * c.unit;
        if (!to_limit) options.stop.ratio = 0.8;
        TetMesh output = input;
        const simplify::SurfaceRunReport report = simplify::simplify_surface(output, options);
        const Judgement judgement = judge_output(output, input);
        EXPECT_EQ(judgement.violations, std::vector<std::string>{});
        const auto& figures = judgement.figures;
        EXPECT_LE(figures.at("surface_distance_upper").get<double>(),
                  std::max(options.max_surface_error, 1e-9));
        EXPECT_EQ(figures.at("surface_self_intersections"), 0);
        EXPECT_EQ(figures.at("euler_unchanged"), true);
        EXPECT_EQ(figures.at("components_unchanged"), true);
        EXPECT_NEAR(figures.at("volume_drift_relative").get<double>(), report.volume_drift_relative, 1e-12);
        EXPECT_TRUE(factor > 0.0 || figures.at("boundary_changed_faces") == 0);  // nothing is flat
        EXPECT_TRUE(factor < 40.0 || 10 * report.boundary_faces_out < 9 * report.boundary_faces_in);
        EXPECT_EQ(report.stop, to_limit ? "limit" : "ratio");
      }
    }
  }
}

struct Spared {
  double distance;       ///< of the skins, in the mesh's unit
  double share_of_good;  ///< above 0.5 of the thesis's quality, %
};

Spared simplify_within(const TetMesh& input, double bound, double ratio, bool sparing) {
  simplify::SurfaceOptions options;
  options.max_surface_error = bound;
  options.stop.ratio = ratio;
  options.sparing = sparing;
  TetMesh output = input;
  EXPECT_EQ(simplify::simplify_surface(output, options).stop, "ratio");
  const Judgement judgement = judge_output(output, input);
  return {judgement.figures.at("surface_distance_upper").get<double>(),
          judgement.figures.at("percent_above_0_5").get<double>()};
}

TEST(OrganSurface, SparingUsesLessOfTheBoundWhereGoodTetsAreToBeHad) {
  for (const char* name : {"kidney", "liver"}) {
    const TetMesh input = make_shape({.name = name}).mesh;
    for (const double ratio : {0.7, 0.8}) {
      SCOPED_TRACE(std::string(name) + " ratio " + std::to_string(ratio));
      const Spared spared = simplify_within(input, 4.0, ratio, true);
      const Spared spent = simplify_within(input, 4.0, ratio, false);
      EXPECT_LT(spared.distance, 0.6 * spent.distance);
      EXPECT_GT(spared.share_of_good, spent.share_of_good - 1.0);
    }
  }
}

/// On a thin leaf a part of the bound leaves poor tets, so more of it is taken.
TEST(OrganSurface, SparingTakesNoPoorTetsInThePlaceOfMoreOfTheBound) {
  const TetMesh input =
      make_shape({.name = "spleen", .size = {.vertices = 1503, .edge_length = {}}, .skin = SkinKind::kFine})
          .mesh;
  for (const double bound : {2.0, 4.0}) {
    SCOPED_TRACE(bound);
    // It was 28 and 31 points below what spending left then; what is spent is evened out more since.
    EXPECT_GT(simplify_within(input, bound, 0.9, true).share_of_good, 80.0);
  }
}

}  // namespace
}  // namespace palpate::experiments

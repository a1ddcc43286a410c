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

}  // namespace
}  // namespace palpate::experiments

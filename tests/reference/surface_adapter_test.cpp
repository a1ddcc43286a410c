// palpate.surface through the door: bounds in metres, units, options and stops.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/judge/surface/surface.h"
#include "core/mesh/io/medit.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/experiment_fixture.h"

namespace palpate::reference {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class SurfaceAdapter : public testing::Test {
 protected:
  SurfaceAdapter() {
    TetMesh mesh = build_kuhn_cube(8, 0.2, 1);
    for (Vec3& p : mesh.points) {  // edges of about 125 units, faces bulged by some 30
      const Vec3 q = p - Vec3{0.5, 0.5, 0.5};
      p = 1000.0 * (1.0 + 0.1 * (0.75 - length_sq(q))) * q;
    }
    write_medit(in_, mesh);
  }

  test::ProgramResult run(const std::vector<std::string>& extra) const {
    std::vector<std::string> arguments{"simplify", in_, "-o", out_, "--method", "palpate.surface", "--json"};
    arguments.insert(arguments.end(), extra.begin(), extra.end());
    return test::run_program(arguments);
  }

  double distance() const {
    return judge::measure_surface_distance(judge::build_boundary(read_medit(out_).mesh),
                                           judge::build_boundary(read_medit(in_).mesh))
        .upper();
  }

  test::ScratchFolder folder_;
  std::string in_ = (folder_ / "in.mesh").string();
  std::string out_ = (folder_ / "out.mesh").string();
};

TEST_F(SurfaceAdapter, TheBoundIsInMetresAndTheUnitSaysWhatThatMeans) {
  const test::ProgramResult in_mm =
      run({"--ratio", "0.8", "--set", "max_surface_error_m=0.02", "--set", "unit_m=0.001"});
  ASSERT_EQ(in_mm.exit_code, 0) << in_mm.error;
  EXPECT_THAT(in_mm.error, HasSubstr("surface within 0.02 m of the input's: 20 units of 0.001 m"));
  const json report = json::parse(in_mm.out);
  EXPECT_EQ(report.at("stop"), "ratio");
  EXPECT_EQ(report.at("max_surface_error_unit"), 20.0);
  EXPECT_GT(report.at("boundary_collapses"), 0);
  EXPECT_LE(distance(), 20.0);
  EXPECT_GT(distance(), 0.5);
  // The same number with the default unit, a metre: next to nothing is permitted.
  const test::ProgramResult in_m = run({"--ratio", "0.8", "--set", "max_surface_error_m=0.02"});
  ASSERT_EQ(in_m.exit_code, 1) << in_m.error;
  EXPECT_THAT(in_m.error, AllOf(HasSubstr("0.02 units of 1 m"), HasSubstr("the count was not reached: ")));
  EXPECT_LE(distance(), 0.02);
}

TEST_F(SurfaceAdapter, WithoutAStopItGoesToTheLimitOfTheBound) {
  const test::ProgramResult coarse = run({"--set", "max_surface_error_m=40"});
  ASSERT_EQ(coarse.exit_code, 0) << coarse.error;
  const json report = json::parse(coarse.out);
  EXPECT_EQ(report.at("stop"), "limit");
  EXPECT_LT(report.at("boundary_faces_out"), 200);  // of 768
  EXPECT_LE(distance(), 40.0);
}

TEST_F(SurfaceAdapter, KeepsRegions) {
  const test::ProgramResult kept = run({"--ratio", "0.7", "--set", "max_surface_error_m=30", "--keep",
                                        "sphere 0 0 550 250", "--set", "near_size=0.5"});
  ASSERT_EQ(kept.exit_code, 0) << kept.error;
  const json report = json::parse(kept.out);
  EXPECT_GT(report.at("kept_tets"), 50);
  EXPECT_EQ(report.at("kept_tets_changed"), 0);
  EXPECT_GT(report.at("boundary_collapses"), 0);
}

TEST_F(SurfaceAdapter, KeepsSharpEdgesByAngle) {
  const test::ProgramResult kept =
      run({"--ratio", "0.9", "--set", "max_surface_error_m=40", "--set", "feature_deg=45"});
  ASSERT_EQ(kept.exit_code, 0) << kept.error;
  EXPECT_THAT(kept.error, AllOf(HasSubstr("96 edges are sharper than 45 degrees: kept as lines of "),
                                HasSubstr(" with 8 corners")));
  const json report = json::parse(kept.out);
  EXPECT_EQ(report.at("feature_edges_in"), 96);
  EXPECT_EQ(report.at("feature_corners"), 8);
  EXPECT_LE(distance(), 40.0);
  const test::ProgramResult none =
      run({"--ratio", "0.9", "--set", "max_surface_error_m=40", "--set", "feature_deg=120"});
  ASSERT_EQ(none.exit_code, 0) << none.error;
  EXPECT_THAT(none.error, HasSubstr("no edge of the skin is sharper than 120 degrees"));
}

TEST_F(SurfaceAdapter, RefusesWhatMakesNoSense) {
  const auto refused = [&](const std::vector<std::string>& extra, const std::string& part) {
    const test::ProgramResult result = run(extra);
    EXPECT_EQ(result.exit_code, 2) << part;
    EXPECT_THAT(result.error, HasSubstr(part));
    EXPECT_FALSE(std::filesystem::exists(out_)) << part;
  };
  refused({"--set", "max_surface_error_m=-1"}, "max_surface_error_m");
  refused({"--set", "unit_m=0"}, "unit_m");
  refused({"--set", "boundary_size=100"}, "boundary_size");
  refused({"--set", "max_error=1"}, "max_error");
  for (const char* degrees : {"180", "-10", "400", "nan", "sharp"})
    refused({"--set", std::string("feature_deg=") + degrees}, "feature_deg");
  refused({"--fusions", "3"}, "only at tets, ratio, limit");
}

}  // namespace
}  // namespace palpate::reference

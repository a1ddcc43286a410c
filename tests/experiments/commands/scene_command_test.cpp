// palpate scene as a program: what it writes passes check and simulate as it stands.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/mesh/io/medit.h"
#include "core/mesh/shapes/body_surfaces.h"
#include "core/mesh/shapes/shapes.h"
#include "experiments/scene_writer/scene_draft.h"
#include "tests/support/experiment_fixture.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/surfaces.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using test::ProgramResult;
using test::run_program;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class SceneCommand : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  /// A lobed body of 100 mm, as a file of a scanner would have it.
  std::string add_lobes() const {
    return folder_.add("lobes.stl", test::binary_stl(build_lobes_surface(8))).string();
  }

  /// Runs palpate scene with these words behind the organ and the output; it must succeed.
  ProgramResult write(const std::string& organ, std::vector<std::string> more = {}) const {
    std::vector<std::string> words{"scene", organ, "-o", path("mine.yaml"), "--force"};
    words.insert(words.end(), more.begin(), more.end());
    ProgramResult result = run_program(words);
    EXPECT_EQ(result.exit_code, 0) << result.error;
    return result;
  }

  void expect_good() const {
    const ProgramResult checked = run_program({"check", path("mine.yaml")});
    EXPECT_EQ(checked.exit_code, 0) << checked.error;
    EXPECT_THAT(checked.out, HasSubstr("mine.yaml: good"));
  }

  /// The report of palpate simulate on what was written.
  json simulated() const {
    const ProgramResult result =
        run_program({"simulate", path("mine.yaml"), "-o", path("results"), "--json"});
    EXPECT_EQ(result.exit_code, 0) << result.error;
    said_ = result.error;
    return result.exit_code == 0 ? json::parse(result.out) : json::object();
  }

  test::ScratchFolder folder_;
  mutable std::string said_;  ///< by simulate, on standard error
};

TEST_F(SceneCommand, ASurfaceBecomesASceneThatCanBeSolved) {
  const ProgramResult written = write(add_lobes(), {"--vertices", "600"});
  const json found = json::parse(write(add_lobes(), {"--vertices", "600", "--json"}).out);
  const BoundaryProblem placed = resolve_draft(folder_ / "mine.yaml");
  ASSERT_EQ(placed.supports.size(), 2U) << "the bed and the pad's layer";
  EXPECT_EQ(found.at("support").at("faces"), placed.supports[0].patch.faces.size());
  EXPECT_EQ(found.at("pad").at("faces"), placed.supports[1].patch.faces.size());
  EXPECT_THAT(written.error, HasSubstr("its unit is the mm, guessed: in mm it is "));
  EXPECT_THAT(written.out, AllOf(HasSubstr("support"), HasSubstr("pad"), HasSubstr("Written: ")));
  const std::string text = test::bytes_of(folder_ / "mine.yaml");
  EXPECT_THAT(text, HasSubstr("mesh: {file: 'lobes.stl', vertices: 600, unit_m: 0.001}"));
  EXPECT_THAT(text, HasSubstr("# unit_m is the length of the file's unit in metres, guessed: in mm it is"));
  EXPECT_THAT(text, HasSubstr("elastic_pa_per_m: 1000000"));
  EXPECT_THAT(
      text,
      HasSubstr("\nrequire: {error: {measure: deformation_l2, at_most: 0.05}, time_per_second_s: 0.5}"));
  EXPECT_THAT(text, HasSubstr("take time_per_second_s out, or have answer_s"));
  expect_good();
  const json report = simulated();
  EXPECT_EQ(report.at("outcome"), "converged");
  EXPECT_NEAR(report.at("vertices").get<double>(), 600.0, 6.0);
  EXPECT_GT(report.at("max_displacement_m").get<double>(), 0.0);
}

TEST_F(SceneCommand, AMeshIsTakenAsItIs) {
  TetMesh mesh = build_kuhn_cube(6, 0.1, 1);
  for (Vec3& p : mesh.points) p = {8.0 * p.x, 6.0 * p.y, 5.0 * p.z};
  write_medit(folder_ / "block.mesh", mesh);
  const json found = json::parse(write(path("block.mesh"), {"--young-pa", "5000", "--poisson", "0.3",
                                                            "--density", "900", "--up", "y", "--json"})
                                     .out);
  EXPECT_EQ(found.at("unit_m"), 0.01) << "11.2 cm, and not 11.2 mm";
  EXPECT_TRUE(found.at("unit_guessed").get<bool>());
  EXPECT_NEAR(found.at("size_m").at(0).get<double>(), 0.08, 1e-12);
  EXPECT_EQ(found.at("vertices"), mesh.points.size());
  EXPECT_GE(found.at("pad").at("edges_wide").get<double>(), 2.0);
  EXPECT_NEAR(found.at("pad").at("push_m").get<double>(), 0.05 * 0.06, 0.0002) << "5% along y, to two digits";
  const std::string text = test::bytes_of(folder_ / "mine.yaml");
  EXPECT_THAT(text, HasSubstr("mesh: {file: 'block.mesh', unit_m: 0.01}"));
  EXPECT_THAT(text, HasSubstr("young_modulus_pa: 5000, poisson_ratio: 0.3, density_kg_m3: 900"));
  EXPECT_THAT(text, HasSubstr("gravity_m_s2: [0, -9.81, 0]"));
  EXPECT_EQ(json::parse(write(path("block.mesh"), {"--json"}).out).at("up"), "z") << "the shortest side";
  EXPECT_THAT(text, HasSubstr("elastic_pa_per_m: 500000"));
  expect_good();
  EXPECT_EQ(simulated().at("outcome"), "converged");
  write(path("block.mesh"), {"--up", "x"});
  EXPECT_THAT(test::bytes_of(folder_ / "mine.yaml"), HasSubstr("gravity_m_s2: [-9.81, 0, 0]"));
}

TEST_F(SceneCommand, UpIsAnyOfSixWays) {
  TetMesh mesh = build_kuhn_cube(6, 0.1, 1);
  for (Vec3& p : mesh.points) p = {8.0 * p.x, 6.0 * p.y, 5.0 * p.z};
  write_medit(folder_ / "block.mesh", mesh);
  const std::map<std::string, std::string> gravity{
      {"x", "[-9.81, 0, 0]"}, {"+x", "[-9.81, 0, 0]"}, {"-x", "[9.81, 0, 0]"}, {"+y", "[0, -9.81, 0]"},
      {"-y", "[0, 9.81, 0]"}, {"+z", "[0, 0, -9.81]"}, {"-z", "[0, 0, 9.81]"}};
  for (const auto& [up, pull] : gravity) {
    SCOPED_TRACE(up);
    const json found = json::parse(write(path("block.mesh"), {"--up", up, "--json"}).out);
    const std::string axis = up.front() == '+' ? up.substr(1) : up;
    EXPECT_EQ(found.at("up"), axis);
    const std::string text = test::bytes_of(folder_ / "mine.yaml");
    EXPECT_THAT(text, HasSubstr("gravity_m_s2: " + pull));
    EXPECT_THAT(text, HasSubstr("# Up is, as asked for, " + axis + ", and gravity pulls along "));
    EXPECT_THAT(text, HasSubstr("--up takes +x, -x, +y, -y, +z and -z."));
    // The pad is on the side that is up, and what holds the body on the other one.
    const std::size_t k = up.back() == 'x' ? 0 : up.back() == 'y' ? 1 : 2;
    const double height = found.at("pad").at("center_m").at(k).get<double>();
    const double size = found.at("size_m").at(k).get<double>();
    EXPECT_EQ(height > 0.5 * size, up.front() != '-') << height;
    const BoundaryProblem placed = resolve_draft(folder_ / "mine.yaml");
    ASSERT_EQ(placed.supports.size(), 2U);
    const Vec3 corner = 0.01 * mesh.points[placed.supports[0].patch.faces.front()[0]];
    const std::array<double, 3> held{corner.x, corner.y, corner.z};
    EXPECT_EQ(held.at(k) > 0.5 * size, up.front() == '-');
  }
  expect_good();
  write(path("block.mesh"), {"--up=-y"});
  EXPECT_THAT(test::bytes_of(folder_ / "mine.yaml"), HasSubstr("and gravity pulls along y."));
}

TEST_F(SceneCommand, AFileThatIsThereIsNotWrittenOver) {
  TetMesh mesh = build_kuhn_cube(4, 0.1, 1);
  for (Vec3& p : mesh.points) p = 80.0 * p;
  write_medit(folder_ / "block.mesh", mesh);
  folder_.add("mine.yaml", "# an afternoon's work\n");
  const std::vector<std::string> words{"scene", path("block.mesh"), "-o", path("mine.yaml")};
  const ProgramResult refused = run_program(words);
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_EQ(refused.error, "palpate: " + path("mine.yaml") +
                               ": expected a new file (--force writes over one), found one that is there "
                               "already\n");
  EXPECT_EQ(test::bytes_of(folder_ / "mine.yaml"), "# an afternoon's work\n");
  write(path("block.mesh"));  // with --force
  EXPECT_THAT(test::bytes_of(folder_ / "mine.yaml"), HasSubstr("schema: palpate/scene/1"));
  std::filesystem::remove(folder_ / "mine.yaml");
  folder_.add("mine.png", "a picture");
  std::vector<std::string> shown = words;
  shown.emplace_back("--show");
  EXPECT_THAT(run_program(shown).error, HasSubstr("mine.png: expected a new file"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "mine.yaml"));
  EXPECT_EQ(run_program(words).exit_code, 0) << "no picture was asked for";
  EXPECT_EQ(test::bytes_of(folder_ / "mine.png"), "a picture");
}

TEST_F(SceneCommand, ADynamicOneMovesAndSaysWhatLimitsIt) {
  TetMesh mesh = build_kuhn_cube(3, 0.1, 1);
  for (Vec3& p : mesh.points) p = 60.0 * p;
  write_medit(folder_ / "block.mesh", mesh);
  write(path("block.mesh"), {"--motion", "dynamic", "--unit-m", "0.001"});
  EXPECT_THAT(test::bytes_of(folder_ / "mine.yaml"), HasSubstr("given: 10.4 cm across"));
  expect_good();
  const json report = simulated();
  EXPECT_EQ(report.at("outcome"), "completed");
  EXPECT_GT(report.at("max_displacement_m").get<double>(), report.at("end_displacement_m").get<double>());
  EXPECT_THAT(said_, HasSubstr("palpate: " + report.at("steps_planned").dump() + " steps of "));
  EXPECT_THAT(said_, HasSubstr("the longest stable step is "));
  EXPECT_THAT(said_, HasSubstr("the fastest motion, which limits the step, is at vertex "));
}

TEST_F(SceneCommand, AnOpenSurfaceIsMendedIfAsked) {
  SurfaceMesh open = build_lobes_surface(8);
  open.triangles.resize(open.triangles.size() - 2);
  const std::string organ = folder_.add("open.stl", test::binary_stl(open)).string();
  const ProgramResult refused = run_program({"scene", organ, "-o", path("mine.yaml")});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.error, AllOf(HasSubstr("border edges (open)"), HasSubstr("--repair may mend it")));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "mine.yaml"));
  EXPECT_THAT(write(organ, {"--repair", "--vertices", "600"}).error, HasSubstr("repaired: "));
  EXPECT_THAT(test::bytes_of(folder_ / "mine.yaml"),
              HasSubstr("vertices: 600, repair: true, unit_m: 0.001}"));
  expect_good();
}

TEST_F(SceneCommand, WhatMakesNoSenseIsRefused) {
  const auto refused = [&](const std::vector<std::string>& more, const std::string& part) {
    std::vector<std::string> words{"scene"};
    words.insert(words.end(), more.begin(), more.end());
    const ProgramResult result = run_program(words);
    EXPECT_EQ(result.exit_code, 2) << result.out;
    EXPECT_THAT(result.error, HasSubstr(part));
    EXPECT_EQ(std::count(result.error.begin(), result.error.end(), '\n'), 1) << result.error;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "mine.yaml"));
  };
  TetMesh mesh = build_kuhn_cube(2, 0.0, 0);
  for (Vec3& p : mesh.points) p = 5000.0 * p;
  write_medit(folder_ / "huge.mesh", mesh);
  const std::string huge = path("huge.mesh");
  const std::string out = path("mine.yaml");
  refused({huge, "-o", out},
          "expected --unit-m, the length of its unit in metres: its box is 8660.25 across");
  refused({huge, "-o", path("mine.txt")}, "an output that ends in .yaml, found \".txt\"");
  refused({huge, "-o", out, "--vertices", "500"}, "--vertices and --repair belong to a surface");
  refused({huge, "-o", out, "--repair"}, "--vertices and --repair belong to a surface");
  refused({huge, "-o", out, "--poisson", "0.5"}, "--poisson: expected a number from -0.99 to 0.4999");
  refused({huge, "-o", out, "--up", "w"}, "--up");
  refused({huge, "-o", out, "--up", "-"}, "--up");
  refused({huge, "-o", out, "--up", "-w"}, "--up");
  refused({huge, "-o", out, "--up"}, "--up");
  refused({huge, "-o", out, "--unit-m", "0"}, "--unit-m: expected a number from");
  refused({huge, "-o", out, "--unit-m", "1e9"},
          "--unit-m: expected a unit in which the body is 1 nm to 1000 km");
  write_medit(folder_ / "one.mesh", TetMesh{{{0, 0, 0}, {90, 0, 0}, {0, 90, 0}, {0, 0, 90}}, {{0, 1, 2, 3}}});
  refused({path("one.mesh"), "-o", out}, "the pad on top: expected a part of the skin that has a front");
  refused({path("none.stl"), "-o", out}, "none.stl");
  refused({huge, "-o", path("no/such/folder/mine.yaml")}, "no/such/folder");
}

TEST_F(SceneCommand, ThePictureLiesBesideTheScene) {
  TetMesh mesh = build_kuhn_cube(4, 0.1, 1);
  for (Vec3& p : mesh.points) p = 80.0 * p;
  write_medit(folder_ / "block.mesh", mesh);
  EXPECT_THAT(write(path("block.mesh"), {"--show"}).out, AllOf(HasSubstr("mine.png"), HasSubstr("mine.svg")));
  EXPECT_EQ(test::bytes_of(folder_ / "mine.png").substr(1, 3), "PNG");
  EXPECT_THAT(test::bytes_of(folder_ / "mine.svg"), HasSubstr("<svg"));
  std::filesystem::remove(folder_ / "mine.png");
  std::filesystem::create_directory(folder_ / "mine.part.png");
  const ProgramResult undrawn =
      run_program({"scene", path("block.mesh"), "-o", path("mine.yaml"), "--force", "--show"});
  EXPECT_EQ(undrawn.exit_code, 3);
  EXPECT_THAT(undrawn.error, HasSubstr("the picture failed"));
  EXPECT_THAT(undrawn.out, Not(HasSubstr("mine.png")));
}

/// palpate mesh and palpate simplify say what stands in the way.
TEST_F(SceneCommand, PoorMeshesComeWithTheWayOut) {
  SurfaceMesh squeezed = build_geodesic_sphere(12);  // 1442 vertices; triangles flat along z
  for (Vec3& p : squeezed.points) p.z *= 0.05;
  const std::string flat = folder_.add("flat.stl", test::ascii_stl(squeezed)).string();
  const ProgramResult poor = run_program({"mesh", flat, "-o", path("flat.mesh")});
  EXPECT_EQ(poor.exit_code, 0) << poor.error;
  EXPECT_THAT(
      poor.error,
      AllOf(HasSubstr("of the tetrahedra have a quality above 0.5"),
            HasSubstr("--vertices N remakes it, with --vertices 1400 for one, where the body is thicker")));
  const std::string ball = folder_.add("ball.stl", test::ascii_stl(build_geodesic_sphere(6))).string();
  const ProgramResult good = run_program({"mesh", ball, "-o", path("ball.mesh")});
  EXPECT_EQ(good.exit_code, 0) << good.error;
  EXPECT_THAT(good.error, Not(HasSubstr("remakes")));
  const ProgramResult kept = run_program({"simplify", path("ball.mesh"), "-o", path("less.mesh"), "--method",
                                          "palpate.refined", "--ratio", "0.6"});
  EXPECT_EQ(kept.exit_code, 0) << kept.error;
  EXPECT_THAT(kept.error, AllOf(HasSubstr("palpate.refined leaves the skin as dense as it was: "),
                                HasSubstr("--method palpate.surface coarsens skin and inside together")));
  const ProgramResult missed = run_program({"simplify", path("ball.mesh"), "-o", path("less.mesh"),
                                            "--method", "palpate.refined", "--ratio", "0.9"});
  EXPECT_EQ(missed.exit_code, 1) << missed.error;
  EXPECT_THAT(missed.error, AllOf(HasSubstr("the count was not reached: "), HasSubstr("palpate.surface")));
  const ProgramResult less = run_program({"simplify", path("ball.mesh"), "-o", path("less.mesh"), "--method",
                                          "palpate.refined", "--ratio", "0.05"});
  EXPECT_THAT(less.error, Not(HasSubstr("dense")));
}

TEST_F(SceneCommand, ANameThatNoSceneCanHoldIsRefusedAndNothingIsWritten) {
  for (const std::string odd : {"two\nlines.mesh", "bell\a.mesh", "delete\x7f.mesh"}) {
    write_medit(folder_ / odd, build_kuhn_cube(6, 0.1, 1));
    const ProgramResult result = run_program({"scene", path(odd), "-o", path("odd.yaml"), "--unit-m", "0.1"});
    EXPECT_EQ(result.exit_code, 2) << result.error;
    EXPECT_THAT(result.error, HasSubstr("expected a path without control characters"));
    EXPECT_EQ(std::count(result.error.begin(), result.error.end(), '\n'), 1) << result.error;
    EXPECT_FALSE(std::filesystem::exists(path("odd.yaml")));
  }
}

}  // namespace
}  // namespace palpate::experiments

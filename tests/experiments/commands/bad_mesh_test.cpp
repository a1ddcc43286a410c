// Bad meshes and bad places through the real program: one message, the right exit code, nothing half-written.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/mesh/io/medit.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/experiment_fixture.h"
#include "tests/support/file_size_limit.h"
#include "tests/support/small_meshes.h"

namespace palpate::experiments {
namespace {

namespace fs = std::filesystem;
using test::ProgramResult;
using test::run_program;
using testing::HasSubstr;

const std::string kHead = "MeshVersionFormatted 2\nDimension 3\nVertices\n";
const std::string kCorners = "0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n";

/// A file of those vertex lines and tetrahedron lines, with true counts.
std::string mesh_of(const std::string& points, const std::string& tets) {
  const auto lines = [](const std::string& text) {
    return std::to_string(std::count(text.begin(), text.end(), '\n'));
  };
  return kHead + lines(points) + "\n" + points + "Tetrahedra\n" + lines(tets) + "\n" + tets + "End\n";
}

struct BadMesh {
  const char* name;
  std::string text;
  const char* said;      ///< by simplify and run
  int quality_code = 2;  ///< 1: can be read and judged, but is not valid
};

std::string garbage() {
  std::string text = "\x7f";
  for (int i = 1; i < 4000; ++i) text += static_cast<char>(i * 7919 % 251);
  return text;
}

const std::vector<BadMesh>& bad_meshes() {
  static const std::vector<BadMesh> meshes{
      {"empty", "", "an empty file"},
      {"truncated", kHead + "4\n0 0 0 0\n1 0 0 0\n", "that the file can hold"},
      {"garbage", garbage(), "MEDIT"},
      {"claims_two_gigabytes", kHead + "80000000\n" + kCorners, "that the file can hold"},
      {"too_few_tets", kHead + "4\n" + kCorners + "Tetrahedra\n2\n1 2 3 4 0\nEnd\n",
       "that the file can hold"},
      {"too_many_points", kHead + "4\n" + kCorners + "2 2 2 0\nTetrahedra\n1\n1 2 3 4 0\nEnd\n", "keyword"},
      {"index_zero", mesh_of(kCorners, "0 2 3 4 0\n"), "a vertex number from 1 to 4"},
      {"index_out_of_range", mesh_of(kCorners, "1 2 3 5 0\n"), "a vertex number from 1 to 4"},
      {"nan", mesh_of("nan 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n", "1 2 3 4 0\n"), "a finite coordinate"},
      {"infinite", mesh_of("0 0 0 0\n1 0 -inf 0\n0 1 0 0\n0 0 1 0\n", "1 2 3 4 0\n"), "a finite coordinate"},
      {"degenerate", mesh_of(kCorners, "1 2 3 3 0\n"), "different vertices"},
      {"flat", mesh_of("0 0 0 0\n1 0 0 0\n0 1 0 0\n1 1 0 0\n", "1 2 3 4 0\n"), "flat", 1},
      {"duplicate", mesh_of(kCorners, "1 2 3 4 0\n1 2 3 4 0\n"), "the same vertices", 1},
      {"non_manifold_face", mesh_of(kCorners + "0 0 -1 0\n0 0 -2 0\n", "1 2 3 4 0\n1 3 2 5 0\n1 3 2 6 0\n"),
       "3 tetrahedra have it", 1},
      {"non_manifold_edge",
       mesh_of("0 0 0 0\n0 0 1 0\n1 0 0 0\n0 1 0 0\n-1 0 0 0\n0 -1 0 0\n", "1 2 3 4 0\n1 2 5 6 0\n"),
       "edge 1 2", 1},
      {"no_tets", mesh_of(kCorners, ""), "expected tetrahedra, found none"},
      {"hexahedron", kHead + "4\n" + kCorners + "Hexahedra\n1\n1 2 3 4 1 2 3 4 0\nEnd\n", "found Hexahedra"},
  };
  return meshes;
}

/// Lines on standard error that are no progress of a run.
std::vector<std::string> messages(const std::string& error) {
  std::vector<std::string> lines;
  std::istringstream stream(error);
  for (std::string line; std::getline(stream, line);) {
    if (line.rfind("palpate: run ", 0) != 0) lines.push_back(line);
  }
  return lines;
}

class BadMeshes : public testing::TestWithParam<BadMesh> {};

TEST_P(BadMeshes, AreRefusedByEachCommand) {
  const test::ExperimentFixture fixture;
  const fs::path in = fixture.folder().add("in.mesh", GetParam().text);
  const ProgramResult quality = run_program({"quality", in.string()});
  EXPECT_EQ(quality.exit_code, GetParam().quality_code) << quality.error;
  if (GetParam().quality_code == 1) {
    EXPECT_THAT(quality.out, HasSubstr("invalid: "));
  } else {
    EXPECT_EQ(quality.out, "");
    EXPECT_EQ(messages(quality.error).size(), 1U) << quality.error;
  }

  for (const char* ending : {".mesh", ".vtu"}) {
    const std::size_t before = fixture.folder().count();
    const fs::path out = fixture.folder() / (std::string("out") + ending);
    const ProgramResult simplify =
        run_program({"simplify", in.string(), "-o", out.string(), "--method", "palpate.hierarchical"});
    EXPECT_EQ(simplify.exit_code, 2);
    EXPECT_THAT(simplify.error, HasSubstr("in.mesh"));
    EXPECT_THAT(simplify.error, HasSubstr(GetParam().said));
    EXPECT_EQ(messages(simplify.error).size(), 1U) << simplify.error;
    EXPECT_EQ(simplify.out, "");
    EXPECT_EQ(fixture.folder().count(), before);
  }
}

TEST_P(BadMeshes, AreNoInputOfARun) {
  const test::ExperimentFixture fixture;
  fixture.folder().add("cube.mesh", GetParam().text);
  const auto plan = fixture.add_plan("[test.copy]");
  const fs::path out = fixture.folder() / "run";
  const ProgramResult run = run_program({"run", plan.string(), "--out", out.string(), "--no-report"});
  EXPECT_EQ(run.exit_code, 2) << run.error;
  EXPECT_THAT(run.error, HasSubstr("plan.yaml:3: mesh cube: "));
  EXPECT_THAT(run.error, HasSubstr(GetParam().said));
  EXPECT_EQ(messages(run.error).size(), 1U) << run.error;
  EXPECT_FALSE(fs::exists(out / "records.jsonl"));
}

INSTANTIATE_TEST_SUITE_P(All, BadMeshes, testing::ValuesIn(bad_meshes()),
                         [](const auto& bad) { return std::string(bad.param.name); });

TEST(BadMesh, MissingFile) {
  const test::ExperimentFixture fixture;
  const std::string in = (fixture.folder() / "none.mesh").string();
  const fs::path out = fixture.folder() / "out.mesh";
  for (const auto& words : std::vector<std::vector<std::string>>{
           {"quality", in},
           {"simplify", in, "-o", out.string(), "--method", "test.copy"},
           {"mesh", in.substr(0, in.size() - 4) + "stl", "-o", out.string()}}) {
    const ProgramResult result = run_program(words);
    EXPECT_EQ(result.exit_code, 2) << words[0];
    EXPECT_THAT(result.error, HasSubstr("none."));
    EXPECT_EQ(messages(result.error).size(), 1U) << result.error;
    EXPECT_FALSE(fs::exists(out));
  }
}

/// So small that no volume is a number: it had been called valid.
TEST(BadMesh, LengthsWhoseCubesAreNothing) {
  const test::ExperimentFixture fixture;
  const fs::path in = fixture.folder().add(
      "in.mesh", mesh_of("0 0 0 0\n1e-200 0 0 0\n0 1e-200 0 0\n0 0 1e-200 0\n", "1 2 3 4 0\n"));
  const ProgramResult result = run_program({"quality", in.string()});
  EXPECT_EQ(result.exit_code, 2) << result.out;
  EXPECT_THAT(result.error, HasSubstr("expected vertices at least 1e-90 apart, found an extent of 1e-200"));
}

TEST(BadMesh, InvertedAndIsolatedElementsAreMendedAndSaid) {
  const test::ExperimentFixture fixture;
  const fs::path in = fixture.folder().add("in.mesh", mesh_of(kCorners + "5 5 5 0\n", "2 1 3 4 0\n"));
  const fs::path out = fixture.folder() / "out.mesh";
  const ProgramResult result = run_program(
      {"simplify", in.string(), "-o", out.string(), "--method", "palpate.hierarchical", "--json"});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr("positive orientation restored"));
  EXPECT_THAT(result.error, HasSubstr("1 vertex that no tetrahedron uses was left out"));
  const nlohmann::json report = nlohmann::json::parse(result.out);
  EXPECT_EQ(report.at("vertices_in"), 4);
  EXPECT_EQ(run_program({"quality", out.string()}).exit_code, 0);
}

TEST(BadMesh, WithoutAnInnerTetrahedronNothingCanBeFused) {
  const test::ExperimentFixture fixture;
  const fs::path in = fixture.folder().add("in.mesh", mesh_of(kCorners, "1 2 3 4 0\n"));
  const fs::path out = fixture.folder() / "out.mesh";
  for (const char* method : {"palpate.hierarchical", "tetfusion.sequential"}) {
    const ProgramResult result =
        run_program({"simplify", in.string(), "-o", out.string(), "--method", method, "--ratio", "0.5"});
    EXPECT_EQ(result.exit_code, 0) << result.error;
    EXPECT_THAT(result.error, HasSubstr("no tetrahedron can be fused"));
    EXPECT_EQ(read_medit(out, ReadOrientation::kKeep).mesh.tets.size(), 1U);
  }
}

TEST(BadMesh, ScaleChangesNoTopology) {
  const test::ExperimentFixture fixture;
  std::vector<std::vector<Tet>> results;
  for (const double scale : {1e-9, 1.0, 1e9}) {
    TetMesh mesh = build_kuhn_cube(6, 0.3, 5);
    for (Vec3& p : mesh.points) p = {p.x * scale, p.y * scale, p.z * scale};
    const fs::path in = fixture.folder() / "in.mesh";
    const fs::path out = fixture.folder() / "out.mesh";
    write_medit(in, mesh);
    const ProgramResult result = run_program(
        {"simplify", in.string(), "-o", out.string(), "--method", "palpate.hierarchical", "--fusions", "6"});
    ASSERT_EQ(result.exit_code, 0) << result.error;
    EXPECT_EQ(run_program({"quality", out.string()}).exit_code, 0);
    results.push_back(read_medit(out, ReadOrientation::kKeep).mesh.tets);
    EXPECT_LT(results.back().size(), mesh.tets.size());
  }
  EXPECT_EQ(results[0], results[1]);
  EXPECT_EQ(results[2], results[1]);
}

TEST(BadStop, OneThatCannotBeReachedIsSaid) {
  const test::ExperimentFixture fixture;
  const std::string in = (fixture.folder() / "large.mesh").string();
  write_medit(in, build_kuhn_cube(6, 0.3, 5));
  const ProgramResult result = run_program({"simplify", in, "-o", (fixture.folder() / "out.mesh").string(),
                                            "--method", "palpate.hierarchical", "--ratio", "0.99"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.error,
              AllOf(HasSubstr("the count was not reached: "),
                    HasSubstr(" tetrahedra are left, and at most 12 were asked for"),
                    HasSubstr("touch the skin of 432 faces, which was kept"), HasSubstr("refused")));
  EXPECT_TRUE(fs::exists(fixture.folder() / "out.mesh"));
}

/// What keeps its skin cannot go below it; what coarsens it can, and the bound that is named does.
TEST(BadStop, TheWayToACountIsNamedAndLeadsThere) {
  const test::ExperimentFixture fixture;
  const std::string in = (fixture.folder() / "large.mesh").string();
  const std::string out = (fixture.folder() / "out.mesh").string();
  const TetMesh mesh = build_kuhn_cube(6, 0.2, 5);
  write_medit(in, mesh);
  const ProgramResult result =
      run_program({"simplify", in, "-o", out, "--method", "palpate.refined", "--ratio", "0.8", "--json"});
  ASSERT_EQ(result.exit_code, 1) << result.error;
  const auto shortfall = nlohmann::json::parse(result.out).at("shortfall");
  EXPECT_GT(shortfall.at("reached_tets"), shortfall.at("wanted_tets"));
  EXPECT_EQ(shortfall.at("wanted_tets").get<double>(),
            std::floor(0.2 * static_cast<double>(mesh.tets.size())));
  ASSERT_EQ(shortfall.at("way_out").at("method"), "palpate.surface") << shortfall.dump(1);
  const std::string bound = shortfall.at("way_out").at("bound").dump();
  EXPECT_THAT(result.error, HasSubstr("--set max_surface_error_m=0 reaches it"));  // its faces are flat
  const ProgramResult other =
      run_program({"simplify", in, "-o", out, "--method", "palpate.surface", "--ratio", "0.8", "--set",
                   "max_surface_error_m=" + bound, "--json"});
  EXPECT_EQ(other.exit_code, 0) << other.error;
  EXPECT_LE(nlohmann::json::parse(other.out).at("tets_out"), shortfall.at("wanted_tets"));
}

/// Removed is the ratio of all, rounded up, whatever 1 - 0.9 is in a double.
TEST(BadStop, ACountThatWasReachedIsNotCalledMissed) {
  const test::ExperimentFixture fixture;
  const std::string in = (fixture.folder() / "box.mesh").string();
  const std::string out = (fixture.folder() / "out.mesh").string();
  write_medit(in, testing_support::make_kuhn_block(1, 2, 5));  // 60 tets
  const ProgramResult result =
      run_program({"simplify", in, "-o", out, "--method", "palpate.surface", "--ratio", "0.9", "--json"});
  EXPECT_EQ(nlohmann::json::parse(result.out).at("tets_out"), 6);
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(result.error.find("asked for"), std::string::npos) << result.error;
}

/// What stops early inside is told of what does not; what strays too little, of a wider bound.
TEST(BadStop, EachIsToldOfWhatIsLeftToTry) {
  const test::ExperimentFixture fixture;
  const std::string in = (fixture.folder() / "large.mesh").string();
  const std::string out = (fixture.folder() / "out.mesh").string();
  write_medit(in, build_kuhn_cube(8, 0.2, 5));
  const std::string ball = (fixture.folder() / "ball.mesh").string();
  ASSERT_EQ(run_program({"make", "ball", "-o", ball, "--vertices", "800"}).exit_code, 0);
  const auto way_of = [&](const std::string& method, const std::vector<std::string>& more) {
    const std::string& mesh = method == "palpate.surface" ? ball : in;
    std::vector<std::string> words{"simplify", mesh, "-o", out, "--method", method, "--json"};
    words.insert(words.end(), more.begin(), more.end());
    const ProgramResult result = run_program(words);
    EXPECT_EQ(result.exit_code, 1) << method;
    return nlohmann::json::parse(result.out).at("shortfall").at("way_out");
  };
  const auto inside = way_of("palpate.hierarchical", {"--ratio", "0.5"});
  EXPECT_EQ(inside.at("method"), "palpate.refined");
  EXPECT_EQ(
      run_program({"simplify", in, "-o", out, "--method", "palpate.refined", "--ratio", "0.5"}).exit_code, 0);
  const auto wider = way_of("palpate.surface", {"--ratio", "0.9", "--set", "max_surface_error_m=0.001"});
  EXPECT_EQ(wider.at("method"), "palpate.surface");
  EXPECT_GT(wider.at("bound"), 0.001);
  EXPECT_EQ(run_program({"simplify", ball, "-o", out, "--method", "palpate.surface", "--ratio", "0.9",
                         "--set", "max_surface_error_m=" + wider.at("bound").dump()})
                .exit_code,
            0);
  // More than that is to be kept: nothing leads there, and nothing is tried.
  EXPECT_TRUE(way_of("palpate.refined", {"--ratio", "0.5", "--keep", "sphere 0 0 0 100"}).is_null());
  EXPECT_THAT(run_program({"simplify", in, "-o", out, "--method", "palpate.refined", "--ratio", "0.5",
                           "--keep", "sphere 0 0 0 100"})
                  .error,
              HasSubstr("lie in regions to keep, which is more than that, so nothing gets there"));
}

TEST(BadPlace, AFullDiskIsSaidAndKeepsNothing) {
  const test::ExperimentFixture fixture;
  const std::string in = (fixture.folder() / "cube.mesh").string();
  for (const char* ending : {".mesh", ".vtu"}) {
    const fs::path full = fixture.folder() / (std::string("full") + ending);
    fs::create_symlink("/dev/full", full);
    const std::size_t before = fixture.folder().count();
    for (const auto& words : std::vector<std::vector<std::string>>{
             {"make", "cube", "-o", full.string()},
             {"simplify", in, "-o", full.string(), "--method", "palpate.hierarchical", "--fusions", "1"}}) {
      const ProgramResult result = run_program(words);
      EXPECT_EQ(result.exit_code, 3) << ending << words[0];
      EXPECT_THAT(result.error, HasSubstr("expected room on the disk"));
      EXPECT_EQ(result.error.find("partial"), std::string::npos) << result.error;
      EXPECT_EQ(result.out, "");
      EXPECT_EQ(fixture.folder().count(), before);
    }
  }
}

TEST(BadPlace, ABoundOnTheSizeOfFilesIsSaidAndKeepsNothing) {
  const test::ExperimentFixture fixture;
  const fs::path out = fixture.folder() / "large.mesh";
  const std::size_t before = fixture.folder().count();
  const test::FileSizeLimit limit(1024);
  std::signal(SIGXFSZ, SIG_DFL);  // the program itself has to see to it
  const ProgramResult result = run_program({"make", "cube", "-o", out.string()});
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_THAT(result.error, HasSubstr("found File too large"));
  EXPECT_EQ(fixture.folder().count(), before);
}

TEST(BadPlace, AFolderOfContestantsThatIsMissing) {
  const test::ExperimentFixture fixture;  // takes the variable back at its end
  ::setenv("PALPATE_CONTESTANTS", "/no/such/folder", 1);
  const ProgramResult result = run_program({"list", "contestants"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(
      result.error,
      "palpate: PALPATE_CONTESTANTS: expected folders of contestants, found no folder /no/such/folder\n");
}

TEST(BadPlace, NoFolderNoFileNoEnding) {
  const test::ExperimentFixture fixture;
  const std::string in = (fixture.folder() / "cube.mesh").string();
  const std::size_t before = fixture.folder().count();
  for (const std::string& out : {in + "/a.mesh", (fixture.folder() / "none/a.vtu").string(),
                                 (fixture.folder() / "a.msh").string(), std::string("/proc/a.mesh")}) {
    for (const auto& words : std::vector<std::vector<std::string>>{
             {"make", "cube", "-o", out}, {"simplify", in, "-o", out, "--method", "test.copy"}}) {
      const ProgramResult result = run_program(words);
      EXPECT_EQ(result.exit_code, 2) << out;
      EXPECT_THAT(result.error, HasSubstr(out));
      EXPECT_EQ(result.out, "");
    }
  }
  EXPECT_EQ(fixture.folder().count(), before);
  const ProgramResult run =
      run_program({"run", fixture.add_plan("[test.copy]").string(), "--out", in + "/run"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.error, HasSubstr("a folder that can be written"));
  EXPECT_EQ(messages(run.error).size(), 1U) << run.error;
}

TEST(BadPlace, TheOutputMayBeTheInput) {
  const test::ExperimentFixture fixture;
  const std::string in = (fixture.folder() / "cube.mesh").string();
  const std::string before = test::bytes_of(in);
  const std::size_t files = fixture.folder().count();
  const ProgramResult result =
      run_program({"simplify", in, "-o", in, "--method", "palpate.hierarchical", "--set", "drop=2"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(test::bytes_of(in), before);
  EXPECT_EQ(run_program({"simplify", in, "-o", in, "--method", "palpate.hierarchical"}).exit_code, 0);
  EXPECT_EQ(run_program({"quality", in}).exit_code, 0);
  EXPECT_EQ(fixture.folder().count(), files);
}

}  // namespace
}  // namespace palpate::experiments

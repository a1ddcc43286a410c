// palpate springs: the CSV, the report, and every refusal.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/dynamics/statics/calibration.h"
#include "core/mesh/io/medit.h"
#include "core/mesh/shapes/shapes.h"
#include "core/springs/identification/identify.h"
#include "core/springs/network/springs_csv.h"
#include "tests/support/experiment_fixture.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using test::ProgramResult;
using test::run_program;
using testing::HasSubstr;

/// A jittered cube of side 1 in a scratch folder.
class SpringsCommand : public testing::Test {
 protected:
  SpringsCommand() : mesh_(build_kuhn_cube(3, 0.2, 4)) { write_medit(folder_ / "cube.mesh", mesh_); }

  std::string mesh_path() const { return (folder_ / "cube.mesh").string(); }
  std::string out() const { return (folder_ / "k.csv").string(); }

  /// The command with these further arguments.
  ProgramResult springs(const std::vector<std::string>& more, const std::string& method = "isotropy_patch",
                        const std::string& young = "10000", const std::string& poisson = "0.25") const {
    std::vector<std::string> words{"springs", mesh_path(),  "-o",  out(),       "--method",
                                   method,    "--young-pa", young, "--poisson", poisson};
    words.insert(words.end(), more.begin(), more.end());
    return run_program(words);
  }

  /// One line on standard error that holds `part`, exit code 2, and no file.
  void expect_refusal(const ProgramResult& result, const std::string& part) const {
    EXPECT_EQ(result.exit_code, 2) << result.error;
    EXPECT_THAT(result.error, HasSubstr("palpate: " + part));
    EXPECT_EQ(std::count(result.error.begin(), result.error.end(), '\n'), 1) << result.error;
    EXPECT_EQ(result.out, "");
    EXPECT_EQ(folder_.count(), 1U) << part;
  }

  test::ScratchFolder folder_;
  TetMesh mesh_;
};

TEST_F(SpringsCommand, WritesTheConstantsOfEachMethod) {
  for (const std::string& name : springs::spring_method_names()) {
    const ProgramResult result = springs({"--json"}, name);
    const json report = json::parse(result.out);
    springs::IdentifyReport expected_report;
    const SpringNetwork expected = springs::identify_springs(
        mesh_, {10000.0, 0.25, 0.0}, springs::parse_spring_method(name), {}, expected_report);
    ASSERT_EQ(result.exit_code, expected_report.hanging_vertices.empty() ? 0 : 1) << result.error;
    EXPECT_EQ(report.at("hanging_vertices"), json(expected_report.hanging_vertices));
    EXPECT_EQ(springs::read_springs_csv(out(), mesh_), expected) << name;
    EXPECT_EQ(report.at("method"), name);
    EXPECT_EQ(report.at("vertices"), mesh_.points.size());
    EXPECT_EQ(report.at("springs"), expected.springs.size());
    EXPECT_EQ(report.at("zero_springs"), expected_report.zero_springs);
    EXPECT_EQ(report.at("iterations"), expected_report.iterations);
    EXPECT_LE(report.at("kkt_relative").get<double>(), 1e-10);
    EXPECT_GT(report.at("kernel_s").get<double>(), 0.0);
    EXPECT_EQ(report.at("stiffness_ratio_mean"), expected_report.stiffness_ratio_mean);
  }
}

TEST_F(SpringsCommand, OptionsUnitsAndMasses) {
  const std::string masses = (folder_ / "m.csv").string();
  const ProgramResult result =
      springs({"--set", "stiffness_n_per_m=42", "--set", "face_opposite=true", "--unit-m", "0.001",
               "--density", "1050", "--masses", masses, "--json"},
              "uniform");
  ASSERT_EQ(result.exit_code, 0) << result.error;
  TetMesh small = mesh_;
  for (Vec3& p : small.points) p = 0.001 * p;
  const SpringNetwork network = springs::read_springs_csv(out(), small);
  EXPECT_GT(network.springs.size(), 0U);
  EXPECT_EQ(network.stiffness_n_per_m, std::vector<double>(network.springs.size(), 42.0));
  EXPECT_NEAR(json::parse(result.out).at("mass_kg").get<double>(), 1050e-9, 1e-18);
  const std::string text = test::bytes_of(masses);
  EXPECT_EQ(text.rfind("vertex,mass_kg\n0,", 0), 0U);
  EXPECT_EQ(static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')), mesh_.points.size() + 1);
}

TEST_F(SpringsCommand, VerticesThatHangOnTooLittleAreNamedAndTheExitCodeSaysSo) {
  const ProgramResult result = springs({}, "thesis_printed");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.error, HasSubstr("2 vertices hang on too little"));
  EXPECT_THAT(result.error, HasSubstr("\"buckled\"): 15, "));
  EXPECT_THAT(result.error, HasSubstr("face_opposite=true"));
  EXPECT_THAT(result.out, HasSubstr("Written: " + out()));
  EXPECT_EQ(springs({"--set", "row_weight=100"}, "thesis_printed").exit_code, 0);
  EXPECT_EQ(springs({}, "van_gelder").exit_code, 0);
}

TEST_F(SpringsCommand, CalibratedSpringsHaveTheModuliOfTheSolidOnTheirOwnMesh) {
  const ProgramResult plain = springs({"--json"});
  const SpringNetwork before = springs::read_springs_csv(out(), mesh_);
  const ProgramResult result = springs({"--json", "--set", "calibrate=true"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const SpringNetwork after = springs::read_springs_csv(out(), mesh_);
  const double factor = json::parse(result.out).at("calibration_factor").get<double>();
  EXPECT_GT(std::abs(factor - 1.0), 1e-3);
  for (std::size_t s = 0; s < before.springs.size(); ++s)
    EXPECT_DOUBLE_EQ(after.stiffness_n_per_m[s], factor * before.stiffness_n_per_m[s]);
  EXPECT_DOUBLE_EQ(json::parse(result.out).at("stiffness_ratio_mean").get<double>(),
                   factor * json::parse(plain.out).at("stiffness_ratio_mean").get<double>());
  // Measured again they need no factor: 5 mu = 2 mu_relaxed + 3 K_relaxed / (5/3).
  const dynamics::ElasticModel model{mesh_.points, after, true, {}, {}};
  EXPECT_NEAR(dynamics::calibration_factor(dynamics::measure_moduli(mesh_, model, {}), 4000.0), 1.0, 1e-9);
  const ProgramResult refused = springs({"--set", "calibrate=yes"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.error, HasSubstr("--set calibrate: expected true or false, found \"yes\""));
}

TEST_F(SpringsCommand, TablesForPeople) {
  const ProgramResult result = springs({});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out, HasSubstr("KKT residual, relative"));
  EXPECT_THAT(result.out, HasSubstr("Written: " + out()));
}

TEST_F(SpringsCommand, WarnsOfARatioThatSpringsCannotHave) {
  const ProgramResult result = springs({}, "van_gelder", "10000", "0.45");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.error, HasSubstr("palpate: springs alone give Poisson's ratio 0.25, not 0.45"));
  EXPECT_EQ(springs({}, "van_gelder").error, "");
}

TEST_F(SpringsCommand, AsksForTheUnitOfAHugeMesh) {
  TetMesh big = mesh_;
  for (Vec3& p : big.points) p = 110.0 * p;
  write_medit(folder_ / "cube.mesh", big);
  EXPECT_THAT(springs({}, "van_gelder").error,
              HasSubstr("the mesh is 110 m long; if its unit is the millimetre, say --unit-m 0.001"));
  EXPECT_EQ(springs({"--unit-m", "0.001"}, "van_gelder").error, "");
  for (const char* unit : {"1e-300", "1e5", "0"}) {
    const ProgramResult none = springs({"--unit-m", unit}, "van_gelder");
    EXPECT_EQ(none.exit_code, 2) << unit;
    EXPECT_THAT(none.error, HasSubstr("--unit-m: expected a")) << unit;
  }
}

TEST_F(SpringsCommand, SaysHowVerticesAreNumberedWhenSomeAreLeftOut) {
  TetMesh lonely = mesh_;
  lonely.points.push_back({0.5, 0.5, 5.0});
  write_medit(folder_ / "cube.mesh", lonely);
  const ProgramResult result = springs({}, "van_gelder");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.error, HasSubstr("vertices of the output are numbered without those left out"));
}

TEST_F(SpringsCommand, MaterialsOutOfRangeAreRefused) {
  for (const char* young : {"0", "-10"})
    expect_refusal(springs({}, "lloyd", young), "--young-pa: expected a finite number above 0");
  for (const char* word : {"nan", "inf", "x", ""})
    expect_refusal(springs({}, "lloyd", word), "springs: --young-pa");
  for (const char* poisson : {"0.5", "-1", "0.7", "-3"}) {
    expect_refusal(springs({}, "lloyd", "1", poisson),
                   std::string("--poisson: expected a number above -1 and below 0.5, found ") + poisson);
  }
  expect_refusal(springs({}, "lloyd", "1", "nan"), "springs: --poisson");
  for (const char* density : {"0", "-1000"}) {
    expect_refusal(springs({"--density", density}, "lloyd"),
                   std::string("--density: expected a finite number above 0, found ") + density);
  }
  expect_refusal(springs({"--unit-m", "0"}, "lloyd"), "--unit-m: expected a finite number above 0, found 0");
  expect_refusal(springs({"--masses", (folder_ / "m.csv").string()}), "--masses: masses need --density");
}

TEST_F(SpringsCommand, UnknownMethodsAndOptionsAreRefused) {
  expect_refusal(springs({}, "isotropc"),
                 "--method: unknown method \"isotropc\"; did you mean \"isotropy\"?");
  expect_refusal(springs({"--set", "row_wight=2"}, "thesis_corrected"),
                 "--set: thesis_corrected has no option \"row_wight\"; it has face_opposite, row_weight");
  expect_refusal(springs({"--set", "patch_length=2"}, "lloyd"), "--set: lloyd has no option");
  expect_refusal(springs({"--set", "row_weight=0"}, "thesis_printed"),
                 "row_weight: expected a finite number above 0, found 0");
  expect_refusal(springs({"--set", "stiffness"}, "uniform"),
                 "--set: expected key=value, found \"stiffness\"");
  expect_refusal(springs({"--set", "stiffness_n_per_m=1", "--set", "stiffness_n_per_m=2"}, "uniform"),
                 "--set: option \"stiffness_n_per_m\" twice");
  expect_refusal(springs({}, "trained"),
                 "--method trained: trained springs are fitted to displacement fields");
}

TEST_F(SpringsCommand, OutputsThatCannotBeWrittenAreRefusedBeforeAnyWork) {
  const auto with_output = [&](const std::string& path) {
    return run_program(
        {"springs", mesh_path(), "-o", path, "--method", "lloyd", "--young-pa", "1", "--poisson", "0.25"});
  };
  expect_refusal(with_output((folder_ / "k.mesh").string()),
                 (folder_ / "k.mesh").string() + ": expected an output that ends in .csv");
  expect_refusal(with_output((folder_ / "none" / "k.csv").string()),
                 (folder_ / "none" / "k.csv").string() + ": expected an output in a folder that exists");
  expect_refusal(springs({"--density", "1", "--masses", out()}), "--masses: the same file as --output");
}

TEST_F(SpringsCommand, BrokenMeshesAreRefused) {
  const auto with_mesh = [&](const std::string& path) {
    return run_program(
        {"springs", path, "-o", out(), "--method", "lloyd", "--young-pa", "1", "--poisson", "0.25"});
  };
  expect_refusal(with_mesh((folder_ / "none.mesh").string()), (folder_ / "none.mesh").string());
  TetMesh twice = mesh_;
  twice.tets.push_back(twice.tets.front());
  write_medit(folder_ / "cube.mesh", twice);
  expect_refusal(with_mesh(mesh_path()), mesh_path() + ": expected a valid mesh");
}

}  // namespace
}  // namespace palpate::experiments

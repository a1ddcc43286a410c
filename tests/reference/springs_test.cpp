// springs.* and smoothed.* through the door of the contest deform.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/mesh/io/medit.h"
#include "core/mesh/shapes/shapes.h"
#include "core/springs/identification/identify.h"
#include "core/springs/network/network.h"
#include "core/springs/network/springs_csv.h"
#include "experiments/files/places.h"
#include "experiments/processes/process.h"
#include "reference/door/deform_problem.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/scratch_folder.h"

namespace palpate::reference {
namespace {

using nlohmann::json;
using testing::HasSubstr;

/// A bar of 4 x 1 x 1 m, pulled at its far end by 50 Pa; E = 1000 Pa.
class SpringsAdapter : public testing::Test {
 protected:
  SpringsAdapter() {
    write_medit(path("in.mesh"), mesh_);
    problem_.material = {1000.0, 0.25, 1000.0};
    for (int axis = 0; axis < 3; ++axis) {
      problem_.held.push_back(
          {testing_support::find_faces_at(mesh_, axis, 0.0), {axis == 0, axis == 1, axis == 2}, {}});
    }
    Traction pull;
    pull.patch.faces = testing_support::find_faces_at(mesh_, 0, 4.0);
    pull.patch.weight.assign(pull.patch.faces.size(), 1.0);
    pull.traction_pa = {50.0, 0.0, 0.0};
    problem_.tractions.push_back(pull);
  }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  /// Starts the adapter as a process; the exit code, and the response as `response_`.
  int run(const std::string& method, const json& options, int threads = 1) {
    std::filesystem::remove(path("u.csv"));
    write("problem.json", problem_to_json(problem_));
    write("request.json", {{"schema", "palpate/request/1"},
                           {"contest", "deform"},
                           {"method", method},
                           {"mesh_in", path("in.mesh")},
                           {"problem_in", path("problem.json")},
                           {"displacement_out", path("u.csv")},
                           {"options", options},
                           {"threads", threads}});
    experiments::ProcessSpec spec;
    spec.arguments = {experiments::program_folder() + "/palpate_springs", path("request.json"),
                      path("response.json")};
    spec.standard_error = folder_ / "error";
    const int code = experiments::run_process(spec).exit_code;
    std::ifstream file(path("response.json"));
    response_ = json::parse(file);
    return code;
  }

  const json& report() const { return response_.at("report"); }
  std::vector<Vec3> displacement() const { return read_displacement(path("u.csv"), mesh_.points.size(), 0); }

  /// Largest distance from the exact answer of uniform tension over its largest displacement.
  double tension_error() const {
    const std::vector<Vec3> u = displacement();
    double worst = 0.0;
    for (std::size_t v = 0; v < u.size(); ++v) {
      const Vec3& p = mesh_.points[v];
      const Vec3 exact = 0.05 * Vec3{p.x, -0.25 * p.y, -0.25 * p.z};
      worst = std::max(worst, length(u[v] - exact) / 0.2);
    }
    return worst;
  }

  void write(const std::string& name, const json& value) const { std::ofstream(path(name)) << value.dump(); }

  test::ScratchFolder folder_;
  TetMesh mesh_ = build_bcc_bar(3);
  BoundaryProblem problem_;
  json response_;
};

TEST_F(SpringsAdapter, SmoothedElementsAreExactInUniformTension) {
  for (const char* method : {"smoothed.blend", "smoothed.edge_node"}) {
    ASSERT_EQ(run(method, json::object()), 0) << response_;
    EXPECT_EQ(report().at("outcome"), "converged");
    EXPECT_LT(tension_error(), 1e-8);
    EXPECT_NEAR(report().at("energy_j").get<double>(), 0.5 * 50.0 * 0.05 * 4.0, 1e-6);
    EXPECT_LE(report().at("solve_s").get<double>(), response_.at("kernel_s").get<double>());
  }
}

TEST_F(SpringsAdapter, EveryMethodAndVolumeModelAnswers) {
  for (const char* method : {"uniform", "van_gelder", "lloyd", "maciel", "stiffness_fit", "thesis_printed",
                             "thesis_corrected", "isotropy", "isotropy_patch"}) {
    ASSERT_EQ(run(std::string("springs.") + method, json::object()), 0) << response_;
    EXPECT_EQ(report().at("outcome"), "converged") << method;
    for (const char* key : {"zero_springs", "kkt_relative", "stiffness_ratio_mean", "identify_s",
                            "assembly_s", "solve_s", "iterations", "residual_relative", "energy_j"})
      EXPECT_TRUE(report().at(key).is_number()) << key;
    EXPECT_EQ(displacement().size(), mesh_.points.size());
  }
  for (const char* volume : {"none", "thesis", "tet", "node_average", "node_smoothed"}) {
    for (const double nu : {0.25, 0.45}) {
      problem_.material.poisson_ratio = nu;
      ASSERT_EQ(
          run("springs.isotropy_patch", {{"volume", volume}, {"face_opposite", true}, {"calibrate", true}}),
          0)
          << response_;
      EXPECT_EQ(report().at("outcome"), "converged") << volume;
      EXPECT_GT(report().at("calibration_factor").get<double>(), 0.5);
    }
  }
}

TEST_F(SpringsAdapter, SpringsAloneWarnOfARatioThatTheyCannotHave) {
  problem_.material.poisson_ratio = 0.45;
  const auto warns = [&](const char* volume) {
    EXPECT_EQ(run("springs.isotropy", {{"volume", volume}}), 0) << response_;
    return response_.at("notes").dump().find("springs alone give Poisson's ratio 0.25, not 0.45") !=
           std::string::npos;
  };
  EXPECT_TRUE(warns("none"));
  EXPECT_FALSE(warns("node_average")) << "which adds what is missing";
}

TEST_F(SpringsAdapter, LargeStrainGoesByNewton) {
  problem_.strain = StrainSize::kLarge;
  for (const char* method : {"smoothed.blend", "springs.van_gelder"}) {
    ASSERT_EQ(run(method, {{"load_steps", 2}}), 0) << response_;
    EXPECT_EQ(report().at("outcome"), "converged");
    EXPECT_GT(report().at("iterations"), 2);
    EXPECT_EQ(report().at("load_steps"), 2);
  }
}

TEST_F(SpringsAdapter, AnOutcomeIsNoErrorAndLeavesNoFile) {
  problem_.strain = StrainSize::kLarge;
  problem_.tractions[0].traction_pa = {-4000.0, 300.0, 0.0};
  ASSERT_EQ(run("springs.van_gelder", {{"max_iterations", 20}}), 0) << response_;
  EXPECT_NE(report().at("outcome"), "converged");
  EXPECT_FALSE(std::filesystem::exists(path("u.csv")));
}

TEST_F(SpringsAdapter, SpringsComeFromAFileToo) {
  springs::IdentifyReport identified;
  const SpringNetwork net =
      springs::identify_springs(mesh_, problem_.material, springs::SpringMethod::kVanGelder, {}, identified);
  springs::write_springs_csv(path("k.csv"), net);
  ASSERT_EQ(run("springs.trained", {{"springs", path("k.csv")}}), 0) << response_;
  const std::vector<Vec3> from_file = displacement();
  ASSERT_EQ(run("springs.van_gelder", json::object()), 0);
  EXPECT_EQ(displacement(), from_file);
  EXPECT_EQ(run("springs.trained", json::object()), 2);
  EXPECT_THAT(response_.at("message").get<std::string>(), HasSubstr("springs"));
  springs::write_springs_csv(path("k.csv"), springs::build_spring_network(build_kuhn_cube(2, 0.0, 1)));
  EXPECT_EQ(run("springs.trained", {{"springs", path("k.csv")}}), 2);
  EXPECT_THAT(response_.at("message").get<std::string>(), HasSubstr("k.csv:"));
  EXPECT_THAT(response_.at("message").get<std::string>(), HasSubstr("the springs are of another mesh"));
}

TEST_F(SpringsAdapter, SpringsThatAreNoTextAreRefusedInWords) {
  for (const std::string bytes :
       {"\xff\xfe\n", "vertex_a,vertex_b,rest_length_m,stiffness_n_per_m\n0,1,\xff\xfe,3\n"}) {
    std::ofstream(path("k.csv"), std::ios::binary) << bytes;
    ASSERT_EQ(run("springs.trained", {{"springs", path("k.csv")}}), 2) << response_;
    EXPECT_EQ(response_.at("status"), "bad_input");
    EXPECT_THAT(response_.at("message").get<std::string>(), HasSubstr("k.csv:"))
        << "names the file and the line";
  }
}

TEST_F(SpringsAdapter, TwoThreadsGiveTheSameBytes) {
  const auto bytes = [&] {
    std::ifstream file(path("u.csv"), std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const json options{{"volume", "node_smoothed"}, {"solver", "conjugate_gradients"}};
  ASSERT_EQ(run("springs.isotropy_patch", options, 1), 0) << response_;
  const std::string one = bytes();
  ASSERT_EQ(run("springs.isotropy_patch", options, 2), 0);
  EXPECT_EQ(one, bytes());
}

TEST_F(SpringsAdapter, BadInputIsOneLine) {
  const auto refused = [&](const std::string& method, const json& options, const char* about) {
    EXPECT_EQ(run(method, options), 2) << method << options;
    EXPECT_EQ(response_.at("status"), "bad_input");
    EXPECT_THAT(response_.at("message").get<std::string>(), HasSubstr(about));
    EXPECT_FALSE(std::filesystem::exists(path("u.csv")));
  };
  refused("springs.elastic", json::object(), "elastic");
  refused("smoothed.cells", json::object(), "smoothed.cells");
  refused("springs.uniform", {{"stiffnes", 3.0}}, "stiffnes");
  refused("springs.van_gelder", {{"patch_length", 1.0}}, "patch_length");
  refused("springs.van_gelder", {{"volume", "air"}}, "volume");
  refused("smoothed.blend", {{"theta", 2.0}}, "theta");
  problem_.material.poisson_ratio = 0.1;
  refused("springs.van_gelder", {{"volume", "node_average"}}, "poisson_ratio");
  problem_.held.pop_back();
  refused("smoothed.blend", json::object(), "left free");
}

TEST_F(SpringsAdapter, ABadMeshIsRefused) {
  std::ofstream(path("in.mesh")) << "MeshVersionFormatted 2\nDimension 3\nVertices\n2\n0 0 0 0\n";
  EXPECT_EQ(run("smoothed.blend", json::object()), 2);
  EXPECT_EQ(response_.at("status"), "bad_input");
}

TEST_F(SpringsAdapter, TheCostOfASimulatedSecondIsThatOfItsSteps) {
  const std::map<std::string, std::pair<std::string, json>> cases{
      {"plain", {"springs.van_gelder", json::object()}},
      {"tets", {"smoothed.edge_node", json::object()}},
      {"general", {"springs.van_gelder", {{"volume", "node_average"}}}}};
  problem_.material.poisson_ratio = 0.45;
  for (const auto& [engine, asked] : cases) {
    json options = asked.second;
    options["step_cost"] = true;
    ASSERT_EQ(run(asked.first, options), 0) << response_.dump();
    EXPECT_EQ(report().at("step_engine"), engine);
    const double step_s = report().at("explicit_step_s").get<double>();
    const double wall_s = report().at("step_wall_s").get<double>();
    EXPECT_GT(wall_s, 0.0);
    EXPECT_NEAR(report().at("simulated_second_s").get<double>(), wall_s / (0.9 * step_s),
                1e-9 * wall_s / step_s);
    // A quarter of the mass: half the step, whatever the model.
    problem_.material.density_kg_m3 /= 4.0;
    ASSERT_EQ(run(asked.first, options), 0) << response_.dump();
    EXPECT_NEAR(report().at("explicit_step_s").get<double>(), 0.5 * step_s, 2e-3 * step_s);
    problem_.material.density_kg_m3 *= 4.0;
  }
}

}  // namespace
}  // namespace palpate::reference

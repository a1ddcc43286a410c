// palpate export, and its file read by docs/read_model.py, which knows nothing of ours: forces and steps.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "core/base/number_text.h"
#include "core/dynamics/integrators/integrator.h"
#include "core/dynamics/reduced/compliance_table.h"
#include "core/mesh/io/medit.h"
#include "core/mesh/shapes/shapes.h"
#include "experiments/files/places.h"
#include "experiments/processes/process.h"
#include "experiments/registry/method_options.h"
#include "reference/elastic_models/model_request.h"
#include "reference/reduced/table_file.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/experiment_fixture.h"
#include "tests/support/motion_cases.h"

namespace palpate::experiments {
namespace {

using test::run_program;
using testing::HasSubstr;

constexpr double kStepS = 1e-4;
constexpr std::uint64_t kSteps = 3;

/// A model to export: what is asked for on the command line, and the same as the engine has it.
struct ExportCase {
  std::string method;
  std::map<std::string, std::string> set;
  Material material;
  std::string strain = "small";
  double stiffness_s = 0.0;
  double mass_per_s = 0.0;
};

class ExportCommand : public testing::Test {
 protected:
  ExportCommand() : mesh_(build_kuhn_cube(2, 0.2, 4)) {
    write_medit(folder() / "cube.mesh", mesh_);
    for (Vec3& p : mesh_.points) p = 0.1 * p;
  }

  const test::ScratchFolder& folder() const { return fixture_.folder(); }
  std::string path(const std::string& name) const { return (folder() / name).string(); }

  test::ProgramResult write(const ExportCase& each) const {
    const auto text = [](double value) {
      std::string out;
      append_number(out, value);
      return out;
    };
    std::vector<std::string> words{"export",     path("cube.mesh"),
                                   "-o",         path("model.json"),
                                   "--method",   each.method,
                                   "--young-pa", text(each.material.young_modulus_pa),
                                   "--poisson",  text(each.material.poisson_ratio),
                                   "--density",  text(each.material.density_kg_m3),
                                   "--unit-m",   "0.1",
                                   "--strain",   each.strain};
    words.insert(words.end(), {"--damping-stiffness-s", text(each.stiffness_s), "--damping-mass-per-s",
                               text(each.mass_per_s)});
    for (const auto& [key, value] : each.set) words.insert(words.end(), {"--set", key + "=" + value});
    return run_program(words);
  }

  dynamics::MotionModel build(const ExportCase& each) const {
    std::map<std::string, GivenOption> given;
    for (const auto& [key, value] : each.set) given[key] = {value, "test"};
    nlohmann::json options = resolve_options(*fixture_.registry().find(each.method)->method, given);
    const auto strain = each.strain == "large" ? StrainSize::kLarge : StrainSize::kSmall;
    const auto wanted = reference::take_model_request(each.method, strain, options);
    reference::Response response;
    dynamics::MotionModel model;
    model.elastic = reference::build_requested_model(mesh_, each.material, wanted, response).model;
    model.mass_kg = dynamics::build_lumped_masses(mesh_, each.material.density_kg_m3);
    model.strain_damping_s = each.stiffness_s;
    for (const double k : model.elastic.springs.stiffness_n_per_m)
      model.spring_damping_n_s_per_m.push_back(each.stiffness_s * k);
    for (const double m : model.mass_kg) model.environment_damping_n_s_per_m.push_back(each.mass_per_s * m);
    return model;
  }

  /// Displacement, velocity and force of each vertex after the steps, by the Python reader.
  std::vector<std::vector<double>> read_and_step(const dynamics::MotionState& start) const {
    std::string state;
    for (std::size_t v = 0; v < mesh_.points.size(); ++v) {
      const Vec3& u = start.displacement_m[v];
      const Vec3& w = start.velocity_m_s[v];
      for (const double value : {u.x, u.y, u.z, w.x, w.y, w.z}) {
        append_number(state, value);
        state += ',';
      }
      state.back() = '\n';
    }
    folder().add("state.csv", state);
    ProcessSpec spec;
    std::string step;
    append_number(step, kStepS);
    spec.arguments = {"/usr/bin/python3",
                      "-B",
                      source_folder() + "/docs/read_model.py",
                      path("model.json"),
                      path("state.csv"),
                      path("out.csv"),
                      step,
                      std::to_string(kSteps)};
    spec.standard_error = path("error.txt");
    const ProcessResult result = run_process(spec);
    EXPECT_EQ(result.exit_code, 0) << result.message << test::bytes_of(path("error.txt"));
    std::ifstream in(path("out.csv"));
    std::vector<std::vector<double>> rows;
    for (std::string line; std::getline(in, line);) {
      std::istringstream words(line);
      rows.emplace_back();
      for (std::string word; std::getline(words, word, ',');) rows.back().push_back(std::stod(word));
    }
    return rows;
  }

  test::ExperimentFixture fixture_;
  TetMesh mesh_;
};

const std::vector<ExportCase> kCases{
    {"springs.isotropy_patch",
     {{"face_opposite", "true"}, {"calibrate", "true"}, {"volume", "node_smoothed"}, {"shear", "edge"}},
     {10000.0, 0.45, 1000.0},
     "small",
     1e-3,
     2.0},
    {"springs.isotropy_patch", {{"volume", "node_average"}}, {10000.0, 0.45, 1000.0}, "large", 0.0, 2.0},
    {"springs.van_gelder", {{"volume", "thesis"}}, {10000.0, 0.25, 1000.0}, "large", 1e-3, 0.0},
    {"smoothed.edge_node", {}, {10000.0, 0.45, 1000.0}, "small", 1e-3, 0.0},
    {"smoothed.blend", {}, {10000.0, 0.3, 1000.0}, "large", 0.0, 1.0},
    {"smoothed.blend", {{"law", "stable_neo_hookean"}}, {10000.0, 0.3, 1000.0}, "large", 0.0, 1.0}};

TEST_F(ExportCommand, AReaderOfAFewLinesMovesTheModelAsOurEngineDoes) {
  for (const ExportCase& each : kCases) {
    SCOPED_TRACE(each.method + ", " + each.strain);
    const test::ProgramResult result = write(each);
    ASSERT_EQ(result.exit_code, 0) << result.error;
    const dynamics::MotionModel model = build(each);
    dynamics::MotionState state;
    state.displacement_m = testing_support::make_random_field(mesh_.points.size(), 2e-3, 1);
    state.velocity_m_s = testing_support::make_random_field(mesh_.points.size(), 0.1, 2);
    const auto rows = read_and_step(state);
    ASSERT_EQ(rows.size(), mesh_.points.size());
    const dynamics::MotionState end =
        testing_support::march(model, {}, state, kStepS * static_cast<double>(kSteps), kSteps);
    std::vector<Vec3> force(mesh_.points.size());
    dynamics::add_elastic_forces(model.elastic, end.displacement_m, force);
    for (std::size_t v = 0; v < force.size(); ++v)
      force[v] = force[v] - (each.mass_per_s * model.mass_kg[v]) * end.velocity_m_s[v];
    double size = 0.0;
    for (const Vec3& f : force) size = std::max(size, length(f));
    double off = 0.0;  // of displacements and velocities
    double off_force = 0.0;
    for (std::size_t v = 0; v < rows.size(); ++v) {
      ASSERT_EQ(rows[v].size(), 9U);
      off = std::max(off, length(Vec3{rows[v][0], rows[v][1], rows[v][2]} - end.displacement_m[v]) / 2e-3);
      off = std::max(off, length(Vec3{rows[v][3], rows[v][4], rows[v][5]} - end.velocity_m_s[v]) / 0.1);
      off_force = std::max(off_force, length(Vec3{rows[v][6], rows[v][7], rows[v][8]} - force[v]) / size);
    }
    // Rounding: sums of some hundred terms, cancelling to a thousandth.
    EXPECT_LT(off, 1e-10);
    if (each.stiffness_s == 0.0) {
      EXPECT_LT(off_force, 1e-10);
    }
    // The oracle sees what is missing: without its damping, or without one term, the motion is another.
    dynamics::MotionModel broken = model;
    if (broken.elastic.strain_terms.empty()) {
      broken.elastic.volume_force.reset();
    } else {
      broken.elastic.strain_terms.pop_back();
    }
    const dynamics::MotionState other =
        testing_support::march(broken, {}, state, kStepS * static_cast<double>(kSteps), kSteps);
    EXPECT_GT(testing_support::field_distance(other.velocity_m_s, end.velocity_m_s), 1e-6);
  }
}

TEST_F(ExportCommand, WhatMakesNoSenseIsRefusedAndNothingIsWritten) {
  const auto refusal = [&](const ExportCase& each) {
    const test::ProgramResult result = write(each);
    EXPECT_EQ(result.exit_code, 2) << result.out;
    EXPECT_EQ(std::count(result.error.begin(), result.error.end(), '\n'), 1) << result.error;
    EXPECT_FALSE(std::filesystem::exists(path("model.json")));
    return result.error;
  };
  const Material good{10000.0, 0.25, 1000.0};
  EXPECT_THAT(refusal({"springs.van_geldr", {}, good}), HasSubstr("did you mean \"springs.van_gelder\"?"));
  EXPECT_THAT(refusal({"fem.p2", {}, good}),
              HasSubstr("is no springs.NAME, smoothed.NAME or reduced.compliance"));
  EXPECT_THAT(refusal({"springs.lloyd", {{"volum", "tet"}}, good}), HasSubstr("did you mean \"volume\"?"));
  EXPECT_THAT(refusal({"springs.lloyd", {{"solver", "direct"}}, good}), HasSubstr("how to solve"));
  EXPECT_THAT(refusal({"springs.lloyd", {}, {10000.0, 0.25, 0.0}}), HasSubstr("--density"));
  EXPECT_THAT(refusal({"springs.lloyd", {}, {10000.0, 0.5, 1000.0}}), HasSubstr("--poisson: expected"));
  EXPECT_THAT(refusal({"springs.uniform", {{"stiffness_n_per_m", "0"}}, good}),
              HasSubstr("stiffness_n_per_m: expected a number, at least 1e-12, found \"0\""));
}

TEST_F(ExportCommand, ATableServesEveryModulusOfItsMesh) {
  const std::vector<std::string> words{"export",    path("cube.mesh"),
                                       "-o",        path("cube.compliance"),
                                       "--method",  "reduced.compliance",
                                       "--unit-m",  "0.1",
                                       "--poisson", "0.3",
                                       "--set",     "precision=double"};
  const test::ProgramResult done = run_program(words);
  ASSERT_EQ(done.exit_code, 0) << done.error;
  const dynamics::ComplianceTable table = reference::read_table(path("cube.compliance"));
  dynamics::ComplianceOptions wanted;
  wanted.poisson_ratio = 0.3;
  EXPECT_EQ(table.body, dynamics::hash_body(mesh_)) << "it is of the mesh in metres";
  EXPECT_EQ(table.options.poisson_ratio, wanted.poisson_ratio);
  EXPECT_EQ(table.options.element_order, wanted.element_order);
  EXPECT_FALSE(table.is_single());
  const std::string bytes = test::bytes_of(path("cube.compliance"));
  for (const std::vector<std::string>& more : {std::vector<std::string>{"--young-pa", "1e4"},
                                               {"--density", "1000"},
                                               {"--strain", "large"},
                                               {"--set", "write_table=true"},
                                               {"--damping-mass-per-s", "1"}}) {
    std::vector<std::string> wrong = words;
    wrong.insert(wrong.end(), more.begin(), more.end());
    const test::ProgramResult refused = run_program(wrong);
    EXPECT_EQ(refused.exit_code, 2) << more.front();
    EXPECT_THAT(refused.error, HasSubstr(more.front() == "--set" ? "write_table" : more.front()));
    EXPECT_EQ(test::bytes_of(path("cube.compliance")), bytes) << "what is there stays";
  }
}

TEST_F(ExportCommand, AModelNeedsItsModulusAndDensity) {
  const std::vector<std::string> words{"export",   path("cube.mesh"), "-o",        path("model.json"),
                                       "--method", "springs.lloyd",   "--poisson", "0.25"};
  const test::ProgramResult refused = run_program(words);
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.error, HasSubstr("--young-pa: expected a number of Pa, found none"));
}

}  // namespace
}  // namespace palpate::experiments

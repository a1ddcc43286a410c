// The tensor-mass model: its forces are the derivatives of the elastic energy, its answers those of linear
// finite elements, and its fault under rotation is as large as predicted.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/mesh/geometry.h"
#include "core/mesh/io/medit.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "experiments/contestants/contestant_run.h"
#include "experiments/files/places.h"
#include "experiments/registry/method_options.h"
#include "experiments/registry/registry.h"
#include "reference/closed_form/known_cases.h"
#include "reference/door/deform_problem.h"
#include "reference/tensor_mass/relaxation.h"
#include "reference/tensor_mass/tensors.h"
#include "tests/support/scratch_folder.h"

namespace palpate::reference {
namespace {

using experiments::ContestantAnswer;
using experiments::ContestantTask;

constexpr Material kSoft{10000.0, 0.3, 1000.0};

std::vector<Vec3> random_field(std::size_t vertices, std::uint64_t seed) {
  SplitMix64 random(seed);
  std::vector<Vec3> field(vertices);
  for (Vec3& u : field) u = {random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
  return field;
}

/// Integral of lambda/2 (tr e)^2 + mu e : e of a field that is linear in each tet, with the gradient from the
/// three edges of a corner, G = [du] [dx]^-1.
double elastic_energy(const TetMesh& mesh, const Material& material, const std::vector<Vec3>& u) {
  double sum = 0.0;
  for (const Tet& t : mesh.tets) {
    const Vec3 a = mesh.points[t[1]] - mesh.points[t[0]];
    const Vec3 b = mesh.points[t[2]] - mesh.points[t[0]];
    const Vec3 c = mesh.points[t[3]] - mesh.points[t[0]];
    const double det = dot(cross(a, b), c);
    const std::array<Vec3, 3> rows{(1.0 / det) * cross(b, c), (1.0 / det) * cross(c, a),
                                   (1.0 / det) * cross(a, b)};  // of [dx]^-1
    std::array<Vec3, 3> g{};                                    // row i: gradient of component i
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 du = u[t[k + 1]] - u[t[0]];
      g[0] = g[0] + du.x * rows[k];
      g[1] = g[1] + du.y * rows[k];
      g[2] = g[2] + du.z * rows[k];
    }
    const double trace = g[0].x + g[1].y + g[2].z;
    const double xy = 0.5 * (g[0].y + g[1].x);
    const double yz = 0.5 * (g[1].z + g[2].y);
    const double zx = 0.5 * (g[2].x + g[0].z);
    const double squares =
        g[0].x * g[0].x + g[1].y * g[1].y + g[2].z * g[2].z + 2.0 * (xy * xy + yz * yz + zx * zx);
    sum += det / 6.0 * (0.5 * material.lambda_pa() * trace * trace + material.mu_pa() * squares);
  }
  return sum;
}

std::vector<Vec3> forces_of(const TensorMass& tensors, const std::vector<Vec3>& u) {
  std::vector<Vec3> force(u.size());
  add_tensor_forces(tensors, u, force);
  return force;
}

double largest(const std::vector<Vec3>& field) {
  double most = 0.0;
  for (const Vec3& v : field) most = std::max(most, length(v));
  return most;
}

/// A rotation by `angle` about the unit vector `axis` (Rodrigues).
Vec3 rotate(const Vec3& axis, double angle, const Vec3& x) {
  return std::cos(angle) * x + std::sin(angle) * cross(axis, x) +
         ((1.0 - std::cos(angle)) * dot(axis, x)) * axis;
}

TEST(TensorMass, ForcesAreMinusTheDerivativesOfTheElasticEnergy) {
  const TetMesh mesh = build_kuhn_cube(2, 0.3, 4);
  const TensorMass tensors = build_tensor_mass(mesh, kSoft);
  std::vector<Vec3> u = random_field(mesh.points.size(), 3);
  const std::vector<Vec3> force = forces_of(tensors, u);
  // The energy is quadratic, so a central difference of any step is exact but for rounding: energies of E
  // size^3 with 16 digits, over the step.
  const double h = 0.1;
  for (std::size_t v = 0; v < u.size(); ++v) {
    for (double Vec3::*axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
      const double middle = u[v].*axis;
      u[v].*axis = middle + h;
      const double up = elastic_energy(mesh, kSoft, u);
      u[v].*axis = middle - h;
      const double down = elastic_energy(mesh, kSoft, u);
      u[v].*axis = middle;
      ASSERT_NEAR(force[v].*axis, -(up - down) / (2 * h), 1e-9 * largest(force)) << "vertex " << v;
    }
  }
}

TEST(TensorMass, TranslationsAndSmallRotationsGiveNoForce) {
  const TetMesh mesh = build_kuhn_cube(3, 0.3, 4);
  const TensorMass tensors = build_tensor_mass(mesh, kSoft);
  const double scale = largest(forces_of(tensors, random_field(mesh.points.size(), 3)));
  std::vector<Vec3> moved(mesh.points.size(), {0.3, -0.2, 0.7});
  EXPECT_LT(largest(forces_of(tensors, moved)), 1e-12 * scale);
  for (std::size_t v = 0; v < moved.size(); ++v) moved[v] = cross({0.2, 0.5, -0.4}, mesh.points[v]);
  EXPECT_LT(largest(forces_of(tensors, moved)), 1e-12 * scale);
}

TEST(TensorMass, ARigidRotationGivesForcesThatGrowWithOneMinusItsCosine) {
  // u = (R - I) x has the strain (cos t - 1) (I - a a^T), so the constant stress -(1 - cos t) (2 lambda I +
  // 2 mu (I - a a^T)): no force inside, and minus that stress times a third of the area around each boundary
  // vertex.
  const TetMesh mesh = build_kuhn_cube(3, 0.3, 4);
  const TensorMass tensors = build_tensor_mass(mesh, kSoft);
  std::vector<Vec3> area(mesh.points.size());
  for (const Triangle& t : build_boundary(mesh)) {
    const auto& p = mesh.points;
    const Vec3 third = (1.0 / 6.0) * cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]);
    for (const Index v : t) area[v] = area[v] + third;
  }
  const Vec3 axis{2.0 / 3.0, -1.0 / 3.0, 2.0 / 3.0};
  for (const double degrees : {1.0, 10.0, 30.0, 90.0, 180.0}) {
    const double angle = degrees * std::acos(-1.0) / 180.0;
    std::vector<Vec3> u(mesh.points.size());
    for (std::size_t v = 0; v < u.size(); ++v) {
      u[v] = rotate(axis, angle, mesh.points[v]) - mesh.points[v];
    }
    const std::vector<Vec3> force = forces_of(tensors, u);
    const double factor = 1.0 - std::cos(angle);
    // Rounding: forces of E x |u| x size, which cancel, with 16 digits.
    const double rounding = 1e-14 * kSoft.young_modulus_pa * largest(u);
    for (std::size_t v = 0; v < u.size(); ++v) {
      const Vec3 across = area[v] - dot(axis, area[v]) * axis;
      const Vec3 predicted = factor * ((2.0 * kSoft.lambda_pa()) * area[v] + (2.0 * kSoft.mu_pa()) * across);
      ASSERT_LT(length(force[v] - predicted), 100 * rounding) << degrees << " degrees, vertex " << v;
    }
    EXPECT_GT(largest(force), 0.1 * factor * kSoft.young_modulus_pa * largest(area));
  }
}

TEST(TensorMass, RelaxesToAKnownAnswer) {
  for (const char* name : {"patch_test", "bar_tension", "bar_pads"}) {
    SCOPED_TRACE(name);
    const KnownCase known = build_known_case(name, 2);
    const dynamics::Loads loads = dynamics::build_loads(known.mesh, known.problem);
    TensorMass tensors = build_tensor_mass(known.mesh, known.problem.material);
    add_supports(loads.supports, tensors);
    const Relaxation found = relax(tensors, loads, {1e-13, 10000});
    ASSERT_TRUE(found.converged);
    std::vector<Vec3> truth;
    for (const Vec3& x : known.mesh.points) truth.push_back(known.displacement(x));
    for (std::size_t v = 0; v < truth.size(); ++v) {
      ASSERT_LT(length(found.displacement_m[v] - truth[v]), 1e-11 * largest(truth));
    }
  }
}

TEST(TensorMass, RunningOutOfIterationsIsAnOutcome) {
  const KnownCase known = build_known_case("bar_tension", 2);
  const dynamics::Loads loads = dynamics::build_loads(known.mesh, known.problem);
  const Relaxation found = relax(build_tensor_mass(known.mesh, known.problem.material), loads, {1e-12, 3});
  EXPECT_FALSE(found.converged);
  EXPECT_EQ(found.iterations, 3U);
  EXPECT_GT(found.residual_relative, 1e-12);
}

/// Asks the program of a method to solve a problem, through the door.
class TensorMassProgram : public ::testing::Test {
 protected:
  ContestantAnswer ask(const std::string& method, const TetMesh& mesh, const BoundaryProblem& problem,
                       const nlohmann::json& options) {
    ContestantTask task;
    task.method = *registry_.find(method);
    EXPECT_EQ(task.method.contestant->unavailable(), "");
    const auto folder = scratch_ / method;
    std::filesystem::create_directory(folder);
    task.mesh_in = folder / "in.mesh";
    write_medit(task.mesh_in, mesh);
    task.problem_in = folder / "problem.json";
    std::ofstream(task.problem_in) << problem_to_json(problem).dump();
    task.scratch = folder / "work";
    std::filesystem::create_directory(task.scratch);
    task.options = experiments::resolve_options(*task.method.method, {});
    task.options.update(options);
    task.timeout_s = 100.0;
    return run_contestant(task);
  }

  experiments::Registry registry_ =
      experiments::load_registry({std::filesystem::path(experiments::source_folder()) / "docs/examples"});
  test::ScratchFolder scratch_;
};

/// A cube on an elastic foot that is pressed by a pad, pulled by its weight, and held at one side.
BoundaryProblem pulled_cube(const TetMesh& mesh) {
  BoundaryProblem problem;
  problem.material = kSoft;
  problem.gravity_m_s2 = {0.0, 1.0, -9.81};
  for (const Triangle& face : build_boundary(mesh)) {
    const Vec3 middle = (1.0 / 3.0) * (mesh.points[face[0]] + mesh.points[face[1]] + mesh.points[face[2]]);
    if (middle.z < 1e-9) {
      if (problem.supports.empty()) problem.supports.push_back({{}, 1e6, {}});
      problem.supports[0].patch.faces.push_back(face);
      problem.supports[0].patch.weight.push_back(middle.x);
    } else if (middle.z > 1.0 - 1e-9) {
      if (problem.tractions.empty()) problem.tractions.push_back({{}, {10.0, 0.0, -50.0}, 20.0});
      problem.tractions[0].patch.faces.push_back(face);
      problem.tractions[0].patch.weight.push_back(middle.y);
    } else if (middle.x < 1e-9) {
      if (problem.held.empty()) problem.held.push_back({{}, {false, true, true}, {0.0, 0.01, 0.0}});
      problem.held[0].faces.push_back(face);
    }
  }
  problem.nodal_forces.push_back({13, {1.0, 2.0, 3.0}});
  return problem;
}

TEST_F(TensorMassProgram, AgreesWithLinearFiniteElements) {
  const TetMesh mesh = build_kuhn_cube(4, 0.25, 6);
  const BoundaryProblem problem = pulled_cube(mesh);
  const ContestantAnswer tensors = ask("tensor_mass", mesh, problem, {{"rtol", 1e-13}});
  const ContestantAnswer elements = ask("fem.p1", mesh, problem, {{"rtol", 1e-13}});
  ASSERT_EQ(tensors.outcome, "ok") << tensors.message;
  ASSERT_EQ(elements.outcome, "ok") << elements.message;
  EXPECT_EQ(tensors.report.at("outcome"), "converged");
  const std::size_t edges = build_edges(mesh).size();
  const std::vector<Vec3> a = read_displacement(tensors.output, mesh.points.size(), edges);
  const std::vector<Vec3> b = read_displacement(elements.output, mesh.points.size(), edges);
  ASSERT_EQ(a.size(), mesh.points.size());
  for (std::size_t v = 0; v < a.size(); ++v) ASSERT_LT(length(a[v] - b[v]), 1e-9 * largest(a)) << v;
  const double energy = elements.report.at("energy_j").get<double>();
  EXPECT_NEAR(tensors.report.at("energy_j").get<double>(), energy, 1e-9 * energy);
}

/// The simulator that docs/your_own_contestant.md walks through has the same elements, assembled and solved
/// densely.
TEST_F(TensorMassProgram, AgreesWithTheExampleOfASimulator) {
  const TetMesh mesh = build_kuhn_cube(3, 0.25, 6);
  const BoundaryProblem problem = pulled_cube(mesh);
  const ContestantAnswer tensors = ask("tensor_mass", mesh, problem, {{"rtol", 1e-13}});
  const ContestantAnswer dense = ask("mine.linear", mesh, problem, nlohmann::json::object());
  ASSERT_EQ(tensors.outcome, "ok") << tensors.message;
  ASSERT_EQ(dense.outcome, "ok") << dense.message;
  const std::size_t edges = build_edges(mesh).size();
  const std::vector<Vec3> a = read_displacement(tensors.output, mesh.points.size(), edges);
  const std::vector<Vec3> b = read_displacement(dense.output, mesh.points.size(), edges);
  for (std::size_t v = 0; v < a.size(); ++v) ASSERT_LT(length(a[v] - b[v]), 1e-9 * largest(a)) << v;
  const double energy = tensors.report.at("energy_j").get<double>();
  EXPECT_NEAR(dense.report.at("energy_j").get<double>(), energy, 1e-9 * energy);
  EXPECT_LT(dense.report.at("residual_relative").get<double>(), 1e-9);
}

TEST_F(TensorMassProgram, SaysWhatIsWrong) {
  const TetMesh mesh = build_kuhn_cube(2, 0.0, 0);
  BoundaryProblem floating;
  floating.material = kSoft;
  floating.gravity_m_s2 = {0, 0, -9.81};
  const ContestantAnswer refused = ask("tensor_mass", mesh, floating, nlohmann::json::object());
  EXPECT_EQ(refused.outcome, "bad_input");
  EXPECT_NE(refused.message.find("translation"), std::string::npos) << refused.message;
}

TEST_F(TensorMassProgram, RunningOutOfIterationsLeavesNoDisplacement) {
  const TetMesh mesh = build_kuhn_cube(4, 0.25, 6);
  const ContestantAnswer answer = ask("tensor_mass", mesh, pulled_cube(mesh), {{"iterations", 2}});
  EXPECT_EQ(answer.outcome, "ok") << answer.message;
  EXPECT_EQ(answer.report.at("outcome"), "not_converged");
  EXPECT_FALSE(std::filesystem::exists(answer.output));
}

}  // namespace
}  // namespace palpate::reference

// Tables of compliances: known answers to rounding, one table for several holdings, and what they refuse.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/dynamics/finite_elements/node_loads.h"
#include "core/dynamics/reduced/compliance_answer.h"
#include "core/dynamics/reduced/modal_basis.h"
#include "core/mesh/geometry.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "reference/closed_form/known_cases.h"
#include "reference/closed_form/structured_mesh.h"

namespace palpate::dynamics {
namespace {

double largest(const std::vector<Vec3>& field) {
  double most = 0.0;
  for (const Vec3& v : field) most = std::max(most, length(v));
  return most;
}

/// Largest difference over the largest size, over the first entries of both.
double difference(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double most = 0.0;
  for (std::size_t v = 0; v < a.size(); ++v) most = std::max(most, length(a[v] - b[v]));
  return most / largest(a);
}

ComplianceTable make_table(const TetMesh& mesh, ComplianceOptions options, double poisson_ratio) {
  options.poisson_ratio = poisson_ratio;
  ComplianceSetup setup;
  return build_compliance_table(mesh, options, factor_simplicial, setup);
}

/// Whole elements, solved at once.
std::vector<Vec3> solve_elements(const TetMesh& mesh, int order, const BoundaryProblem& problem) {
  const ElementSpace space = build_element_space(mesh, order);
  const ElementMatrices body = build_element_matrices(mesh, space, problem.material);
  const NodeLoads loads = build_node_loads(mesh, space, problem, BodyForces::kInclude);
  BlockMatrix stiffness = body.stiffness;
  add_support_stiffness(loads, order, stiffness);
  const HeldElements held(body, stiffness, loads.held, factor_simplicial);
  std::vector<Vec3> force = loads.force_n;
  const FaceMass mass = unit_face_mass(order);
  for (const ElasticFace& face : loads.faces) {
    for (std::size_t i = 0; i < space.nodes_per_face(); ++i) {
      for (std::size_t j = 0; j < space.nodes_per_face(); ++j)
        force[face.nodes[i]] = force[face.nodes[i]] + (face.coefficient_n_per_m * mass[i][j]) * face.by_m;
    }
  }
  return held.rest_under(force, loads.held_by_m);
}

std::vector<Triangle> faces_where(const TetMesh& mesh, const std::function<bool(const Vec3&)>& is_there) {
  return reference::select_boundary(mesh, is_there);
}

FacePatch patch_of(std::vector<Triangle> faces, double weight) {
  std::vector<double> weights(faces.size(), weight);
  return {std::move(faces), std::move(weights)};
}

/// A jittered cube on an elastic foot, pulled by its weight, a traction, a pressure and a force, pressed by a
/// pad over part of each face.
BoundaryProblem loaded_cube(const TetMesh& mesh) {
  BoundaryProblem problem;
  problem.material = {2e4, 0.3, 1000.0};
  problem.gravity_m_s2 = {0.0, 1.0, -9.81};
  const auto top = faces_where(mesh, [](const Vec3& p) { return p.z > 1.0 - 1e-9; });
  problem.supports.push_back(
      {patch_of(faces_where(mesh, [](const Vec3& p) { return p.z < 1e-9; }), 1.0), 1e6, {}});
  problem.supports.push_back({patch_of({top[0], top[3]}, 0.4), 2e6, {0.0, 0.01, -0.02}});
  problem.tractions.push_back({patch_of({top[1], top[2]}, 0.7), {10.0, 0.0, -50.0}, 20.0});
  problem.nodal_forces.push_back({mesh.tets.empty() ? 0U : top[4][0], {1.0, 2.0, 3.0}});
  return problem;
}

/// The same cube held hard at a side, in two axes with a shift, and by the foot.
BoundaryProblem clamped_cube(const TetMesh& mesh) {
  BoundaryProblem problem = loaded_cube(mesh);
  problem.supports.pop_back();
  problem.held.push_back(
      {faces_where(mesh, [](const Vec3& p) { return p.x < 1e-9; }), {false, true, true}, {0.0, 0.01, 0.0}});
  return problem;
}

struct Exact {
  int elements;
  int reactions;
};
constexpr Exact kLinear{1, 1};
constexpr Exact kQuadratic{2, 2};

TEST(ElementMatrices, MassIsTheBodysAndRigidMotionsHaveNoForce) {
  const TetMesh mesh = build_kuhn_cube(2, 0.3, 4);
  for (const int order : {1, 2}) {
    const ElementSpace space = build_element_space(mesh, order);
    const ElementMatrices body = build_element_matrices(mesh, space, {1e4, 0.3, 700.0});
    std::vector<Vec3> ones(space.nodes(), {1.0, 0.0, 0.0});
    std::vector<Vec3> product(space.nodes());
    multiply_mass(body, ones, product);
    double total = 0.0;
    for (const Vec3& p : product) total += p.x;
    EXPECT_NEAR(total, 700.0 * total_volume(mesh), 1e-10 * total) << order;
    for (std::size_t v = 0; v < space.nodes(); ++v) ones[v] = cross({0.3, -0.2, 0.5}, space.points[v]);
    multiply(body.stiffness, ones, product);
    EXPECT_LT(largest(product), 1e-10 * 1e4) << order;
  }
}

TEST(ElementMatrices, FaceMassesIntegrateProducts) {
  // The integral of (x + 2 y)^2 over the triangle (0,0) (1,0) (0,1) is 1/12 + 4/24 + 4/12 = 7/12: of a
  // quadratic field with itself at order 1, exactly; of x^2 with y^2, 4/360 = 1/90... at order 2.
  const std::array<std::array<double, 2>, 6> at{{{0, 0}, {1, 0}, {0, 1}, {0.5, 0}, {0.5, 0.5}, {0, 0.5}}};
  for (const int order : {1, 2}) {
    const FaceMass mass = unit_face_mass(order);
    const std::size_t count = order == 1 ? 3 : 6;
    double linear = 0.0;
    double quartic = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t j = 0; j < count; ++j) {
        linear += 0.5 * mass[i][j] * (at[i][0] + 2 * at[i][1]) * (at[j][0] + 2 * at[j][1]);
        quartic += 0.5 * mass[i][j] * at[i][0] * at[i][0] * at[j][1] * at[j][1];
      }
    }
    EXPECT_NEAR(linear, 7.0 / 12.0, 1e-14);
    if (order == 2) {
      EXPECT_NEAR(quartic, 4.0 / 720.0, 1e-14);  // 2! 2! / 6!
    }
  }
}

TEST(ComplianceTable, GivesKnownAnswersToRounding) {
  for (const char* name : {"patch_test", "bar_tension", "bar_pads"}) {
    const reference::KnownCase known = reference::build_known_case(name, 2);
    std::vector<Vec3> truth;
    for (const Vec3& x : known.mesh.points) truth.push_back(known.displacement(x));
    for (const Exact exact : {kLinear, kQuadratic}) {
      SCOPED_TRACE(std::string(name) + " " + std::to_string(exact.elements));
      const ComplianceTable table = make_table(known.mesh, {exact.elements, 0, exact.reactions, 0.0},
                                               known.problem.material.poisson_ratio);
      const ComplianceAnswer found = HeldBody(table, known.mesh, known.problem).solve(known.problem);
      EXPECT_LT(difference(truth, found.displacement_m), 1e-9);
      EXPECT_LT(found.residual_relative, 1e-9);
    }
  }
}

TEST(ComplianceTable, ABarUnderItsOwnWeightIsQuadratic) {
  const reference::KnownCase known = reference::build_known_case("bar_own_weight", 2);
  std::vector<Vec3> truth;
  for (const Vec3& x : known.mesh.points) truth.push_back(known.displacement(x));
  const ComplianceTable table = make_table(known.mesh, {2, 0, 2, 0.0}, known.problem.material.poisson_ratio);
  const ComplianceAnswer found = HeldBody(table, known.mesh, known.problem).solve(known.problem);
  EXPECT_LT(difference(truth, found.displacement_m), 1e-9);
  // The same with linear tractions is near, and no more than that.
  const ComplianceTable coarse = make_table(known.mesh, {2, 0, 1, 0.0}, known.problem.material.poisson_ratio);
  const double off =
      difference(truth, HeldBody(coarse, known.mesh, known.problem).solve(known.problem).displacement_m);
  EXPECT_LT(off, 0.1);
  EXPECT_GT(off, 1e-7);
}

TEST(ComplianceTable, OneTableServesTwoHoldingsAsWholeElementsDo) {
  const TetMesh mesh = build_kuhn_cube(2, 0.25, 6);
  for (const Exact exact : {kLinear, kQuadratic}) {
    const ComplianceTable table = make_table(mesh, {exact.elements, 0, exact.reactions, 0.0}, 0.3);
    for (const BoundaryProblem& problem : {loaded_cube(mesh), clamped_cube(mesh)}) {
      std::vector<Vec3> whole = solve_elements(mesh, exact.elements, problem);
      whole.resize(mesh.points.size());
      const ComplianceAnswer found = HeldBody(table, mesh, problem).solve(problem);
      EXPECT_LT(difference(whole, found.displacement_m), 1e-9) << exact.elements;
      EXPECT_LT(found.residual_relative, 1e-9);
    }
  }
}

TEST(ComplianceTable, TheEnergyIsHalfTheWorkOfTheForces) {
  // At rest 2 W = f . u over all forces, supports and weight among them; the potential is -1/2 (work of what
  // is prescribed), here by its own terms.
  const TetMesh mesh = build_kuhn_cube(2, 0.25, 6);
  BoundaryProblem problem = loaded_cube(mesh);
  problem.supports[1].by_m = {};
  const ComplianceTable table = make_table(mesh, {2, 0, 2, 0.0}, 0.3);
  const ComplianceAnswer found = HeldBody(table, mesh, problem).solve(problem);
  // With supports at rest the whole potential is linear in the loads: W + support energy = -potential.
  EXPECT_LT(found.potential_j, 0.0);
  EXPECT_GT(found.energy_j, 0.0);
  EXPECT_LT(found.energy_j, -found.potential_j);
  // And it does not move, to second order, with the loads' share: potential(2 f) = 4 potential(f).
  BoundaryProblem twice = problem;
  twice.gravity_m_s2 = 2.0 * twice.gravity_m_s2;
  twice.tractions[0].traction_pa = 2.0 * twice.tractions[0].traction_pa;
  twice.tractions[0].pressure_pa *= 2.0;
  twice.nodal_forces[0].force_n = 2.0 * twice.nodal_forces[0].force_n;
  const ComplianceAnswer more = HeldBody(table, mesh, twice).solve(twice);
  EXPECT_NEAR(more.potential_j, 4.0 * found.potential_j, 1e-9 * std::fabs(more.potential_j));
  // Supports bear all that acts.
  Vec3 sum;
  for (const Vec3& f : found.support_forces_n) sum = sum + f;
  const Vec3 weight = (1000.0 * total_volume(mesh)) * problem.gravity_m_s2;
  Vec3 loads = weight + problem.nodal_forces[0].force_n;
  for (const Triangle& face : problem.tractions[0].patch.faces) {
    const Vec3 area =
        0.5 * cross(mesh.points[face[1]] - mesh.points[face[0]], mesh.points[face[2]] - mesh.points[face[0]]);
    loads = loads + 0.7 * (length(area) * problem.tractions[0].traction_pa - 20.0 * area);
  }
  EXPECT_LT(length(sum + loads), 1e-9 * length(loads));
}

TEST(ComplianceTable, IsSymmetricAndServesAnyYoungsModulus) {
  const TetMesh mesh = build_kuhn_cube(2, 0.25, 6);
  const ComplianceTable table = make_table(mesh, {2, 0, 1, 0.0}, 0.3);
  BoundaryProblem problem = loaded_cube(mesh);
  const std::vector<Vec3> soft = HeldBody(table, mesh, problem).solve(problem).displacement_m;
  problem.material.young_modulus_pa *= 10.0;
  for (ElasticSupport& support : problem.supports) support.stiffness_pa_per_m *= 10.0;
  problem.gravity_m_s2 = 10.0 * problem.gravity_m_s2;
  for (Traction& traction : problem.tractions) {
    traction.traction_pa = 10.0 * traction.traction_pa;
    traction.pressure_pa *= 10.0;
  }
  problem.nodal_forces[0].force_n = 10.0 * problem.nodal_forces[0].force_n;
  EXPECT_LT(difference(soft, HeldBody(table, mesh, problem).solve(problem).displacement_m), 1e-10);
}

TEST(ComplianceTable, RefinedElementsComeNearerToTheirLimit) {
  // A cube that hangs in an elastic bed on all sides: the bed's traction is continuous, as the table's are,
  // so that the elements alone decide. Against quadratic elements on the refined mesh, solved at once.
  const TetMesh mesh = build_kuhn_cube(2, 0.25, 6);
  BoundaryProblem problem;
  problem.material = {2e4, 0.3, 1000.0};
  problem.gravity_m_s2 = {1.0, 2.0, -9.81};
  problem.supports.push_back({patch_of(build_boundary(mesh), 1.0), 1e4, {}});
  const TetMesh fine = refine_uniformly(mesh);
  std::vector<Vec3> limit = solve_elements(fine, 2, refine_problem(problem, mesh, fine));
  limit.resize(mesh.points.size());
  const auto off = [&](const ComplianceOptions& options) {
    const ComplianceTable table = make_table(mesh, options, 0.3);
    return difference(limit, HeldBody(table, mesh, problem).solve(problem).displacement_m);
  };
  const double coarse = off({2, 0, 2, 0.0});
  EXPECT_LT(off({2, 1, 2, 0.0}), 0.5 * coarse);
  EXPECT_LT(off({1, 1, 1, 0.0}), off({1, 0, 1, 0.0}));
}

TEST(ComplianceTable, SinglePrecisionMovesAnswersByLessThanATenThousandth) {
  const TetMesh mesh = build_kuhn_cube(3, 0.25, 6);
  const BoundaryProblem problem = loaded_cube(mesh);
  const ComplianceTable table = make_table(mesh, {2, 0, 1, 0.0}, 0.3);
  const std::vector<Vec3> whole = HeldBody(table, mesh, problem).solve(problem).displacement_m;
  const ComplianceTable half = to_single(table);
  EXPECT_EQ(2 * half.skin_bytes(), table.skin_bytes());
  EXPECT_EQ(2 * half.field_bytes(), table.field_bytes());
  const double off = difference(whole, HeldBody(half, mesh, problem).solve(problem).displacement_m);
  EXPECT_LT(off, 1e-4);
  EXPECT_GT(off, 0.0);
}

TEST(ComplianceTable, RefusesWhatItCannotDo) {
  const TetMesh mesh = build_kuhn_cube(2, 0.25, 6);
  const ComplianceTable table = make_table(mesh, {1, 0, 1, 0.0}, 0.3);
  const BoundaryProblem problem = loaded_cube(mesh);
  EXPECT_NO_THROW(HeldBody(table, mesh, problem));
  const auto message = [&](const TetMesh& other, const BoundaryProblem& asked) -> std::string {
    try {
      HeldBody(table, other, asked).solve(asked);
    } catch (const InputError& error) {
      return error.what();
    }
    return "nothing";
  };
  TetMesh moved = mesh;
  moved.points[3].x += 1e-9;
  EXPECT_NE(message(moved, problem).find("one of another mesh"), std::string::npos);
  BoundaryProblem wrong = problem;
  wrong.material.poisson_ratio = 0.31;
  EXPECT_NE(message(mesh, wrong).find("Poisson"), std::string::npos);
  wrong = problem;
  wrong.strain = StrainSize::kLarge;
  EXPECT_NE(message(mesh, wrong).find("linear"), std::string::npos);
  wrong = problem;
  const std::vector<std::uint8_t> on_skin = build_boundary_vertex_flags(mesh);
  for (std::size_t v = 0; v < on_skin.size(); ++v) {
    if (on_skin[v] == 0) wrong.nodal_forces.push_back({static_cast<Index>(v), {1, 0, 0}});
  }
  ASSERT_GT(wrong.nodal_forces.size(), 1U);
  EXPECT_NE(message(mesh, wrong).find("inside the body"), std::string::npos);
  wrong = problem;
  wrong.supports.clear();
  EXPECT_NE(message(mesh, wrong).find("translation"), std::string::npos);
  wrong = problem;
  wrong.body_force_n_m3.assign(mesh.points.size() + build_edges(mesh).size(), {1, 0, 0});
  EXPECT_NE(message(mesh, wrong).find("body_force"), std::string::npos);
}

TEST(ComplianceTable, RefusesABodyInTwoPartsAndOptionsThatDoNotFit) {
  TetMesh two = build_kuhn_cube(1, 0.0, 0);
  const auto first = static_cast<Index>(two.points.size());
  const TetMesh one = two;
  for (const Vec3& p : one.points) two.points.push_back(p + Vec3{3, 0, 0});
  for (const Tet& t : one.tets) two.tets.push_back({t[0] + first, t[1] + first, t[2] + first, t[3] + first});
  EXPECT_THROW(make_table(two, {1, 0, 1, 0.0}, 0.3), InputError);
  EXPECT_THROW(make_table(one, {1, 0, 2, 0.0}, 0.3), InputError);
  EXPECT_THROW(make_table(one, {3, 0, 1, 0.0}, 0.3), InputError);
  EXPECT_THROW(make_table(one, {1, 2, 1, 0.0}, 0.3), InputError);
}

TEST(ComplianceTable, LoadsOfOtherSupportsAreRefusedWithFactorsOfTheFirst) {
  const TetMesh mesh = build_kuhn_cube(2, 0.25, 6);
  const ComplianceTable table = make_table(mesh, {1, 0, 1, 0.0}, 0.3);
  const BoundaryProblem problem = loaded_cube(mesh);
  const HeldBody held(table, mesh, problem);
  BoundaryProblem moved = problem;
  moved.supports[1].by_m = {0.0, 0.0, -0.03};
  EXPECT_LT(
      difference(HeldBody(table, mesh, moved).solve(moved).displacement_m, held.solve(moved).displacement_m),
      1e-12);
  EXPECT_THROW(held.solve(clamped_cube(mesh)), InputError);
}

}  // namespace
}  // namespace palpate::dynamics

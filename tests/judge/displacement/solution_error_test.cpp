#include "core/judge/displacement/solution_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "core/base/error.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"

namespace palpate::judge {
namespace {

using FieldFunction = std::function<Vec3(const Vec3&)>;

std::vector<Vec3> at_vertices(const TetMesh& mesh, const FieldFunction& field) {
  std::vector<Vec3> values;
  for (const Vec3& x : mesh.points) values.push_back(field(x));
  return values;
}

std::vector<Vec3> at_nodes(const TetMesh& mesh, const FieldFunction& field) {
  std::vector<Vec3> values = at_vertices(mesh, field);
  for (const auto& [a, b] : build_edges(mesh))
    values.push_back(field(0.5 * (mesh.points[a] + mesh.points[b])));
  return values;
}

const FieldFunction kLinear = [](const Vec3& x) {
  return Vec3{1 + x.x - 2 * x.y, x.z + 0.5 * x.x, 3 * x.y - x.z};
};
const FieldFunction kQuadratic = [](const Vec3& x) {
  return Vec3{x.x * x.y + x.z, x.z * x.z - x.x, 1 + x.y * x.y - x.x * x.z};
};

TEST(SolutionError, IsZeroForWhatTheFieldCanHold) {
  const TetMesh mesh = build_kuhn_cube(3, 0.3, 2);
  EXPECT_LT(compare_with_solution(mesh, at_vertices(mesh, kLinear), kLinear).relative_max, 1e-14);
  EXPECT_LT(compare_with_solution(mesh, at_nodes(mesh, kLinear), kLinear).relative_l2, 1e-14);
  EXPECT_LT(compare_with_solution(mesh, at_nodes(mesh, kQuadratic), kQuadratic).relative_l2, 1e-14);
  EXPECT_GT(compare_with_solution(mesh, at_vertices(mesh, kQuadratic), kQuadratic).relative_l2, 1e-3);
}

TEST(SolutionError, IntegratesPolynomialsOfDegreeSevenExactly) {
  // With a field of zero, l2^2 is the integral of |truth|^2 over the unit cube: x^6 + x^2 y^2 z^2, then x^3
  // y^2 z^2.
  const TetMesh mesh = build_kuhn_cube(1, 0.0, 0);
  const std::vector<Vec3> zero(mesh.points.size());
  const FieldFunction cubic = [](const Vec3& x) { return Vec3{x.x * x.x * x.x, 0, x.x * x.y * x.z}; };
  EXPECT_NEAR(std::pow(compare_with_solution(mesh, zero, cubic).l2, 2), 1.0 / 7.0 + 1.0 / 27.0, 1e-15);
  const FieldFunction root = [](const Vec3& x) { return Vec3{std::sqrt(x.x * x.x * x.x) * x.y * x.z, 0, 0}; };
  EXPECT_NEAR(std::pow(compare_with_solution(mesh, zero, root).l2, 2), 1.0 / 36.0, 1e-15);
}

TEST(SolutionError, OfAKnownGapIsThatGap) {
  // u - truth = (0.3, 0, -0.4) everywhere: 0.5 sqrt(volume), over |truth| = 2.
  const TetMesh mesh = build_kuhn_cube(4, 0.2, 8);
  const FieldFunction truth = [](const Vec3&) { return Vec3{0, 2, 0}; };
  const std::vector<Vec3> field(mesh.points.size(), {0.3, 2, -0.4});
  const SolutionError error = compare_with_solution(mesh, field, truth);
  EXPECT_NEAR(error.l2, 0.5, 1e-14);
  EXPECT_NEAR(error.relative_l2, 0.25, 1e-14);
  EXPECT_NEAR(error.relative_max, 0.25, 1e-14);
}

TEST(SolutionError, SeesBetweenTheNodes) {
  // A wave that is zero at all nodes: the nodal error is none, the true one is the whole wave.
  const TetMesh mesh = build_kuhn_cube(2, 0.0, 0);
  const FieldFunction wave = [](const Vec3& x) { return Vec3{std::sin(4 * 3.14159265358979 * x.x), 0, 0}; };
  const SolutionError error = compare_with_solution(mesh, at_nodes(mesh, wave), wave);
  EXPECT_NEAR(error.relative_l2, 1.0, 1e-6);
}

TEST(SolutionError, FallsWithTheOrderOfTheShapeFunctions) {
  const FieldFunction wave = [](const Vec3& x) {
    return Vec3{std::sin(x.x + 2 * x.y), std::cos(x.z), std::exp(x.x)};
  };
  std::vector<double> linear;
  std::vector<double> quadratic;
  for (const int cells : {4, 8}) {
    const TetMesh mesh = build_kuhn_cube(cells, 0.0, 0);
    linear.push_back(compare_with_solution(mesh, at_vertices(mesh, wave), wave).relative_l2);
    quadratic.push_back(compare_with_solution(mesh, at_nodes(mesh, wave), wave).relative_l2);
  }
  // Interpolation errors of h^2 and h^3 with relative remainders of h.
  EXPECT_NEAR(observed_order(linear[0], 4, linear[1], 8), 2.0, 0.1);
  EXPECT_NEAR(observed_order(quadratic[0], 4, quadratic[1], 8), 3.0, 0.1);
}

TEST(SolutionError, ObservedOrderOfAPowerIsItsExponent) {
  EXPECT_NEAR(observed_order(7 * std::pow(3.0, -2.5), 3, 7 * std::pow(5.0, -2.5), 5), 2.5, 1e-14);
  EXPECT_LT(observed_order(1.0, 2, 2.0, 4), 0.0);
  EXPECT_THROW(observed_order(0.0, 2, 1.0, 4), ContractError);
  EXPECT_THROW(observed_order(1.0, 4, 1.0, 4), ContractError);
}

TEST(SolutionError, StressOfALinearFieldIsHookesLawOnce) {
  const TetMesh mesh = build_kuhn_cube(3, 0.3, 2);
  const double lambda = 3.0;
  const double mu = 2.0;
  for (const auto& field : {at_vertices(mesh, kLinear), at_nodes(mesh, kLinear)}) {
    for (Index v = 0; v < mesh.points.size(); v += 7) {
      const auto s = stress_at_vertex(mesh, field, v, lambda, mu);
      // Gradient rows (1, -2, 0), (0.5, 0, 1), (0, 3, -1): trace 0.
      EXPECT_NEAR(s[0].x, 2 * mu * 1, 1e-12);
      EXPECT_NEAR(s[0].y, mu * -1.5, 1e-12);
      EXPECT_NEAR(s[1].x, mu * -1.5, 1e-12);
      EXPECT_NEAR(s[1].y, 0, 1e-12);
      EXPECT_NEAR(s[1].z, mu * 4, 1e-12);
      EXPECT_NEAR(s[2].x, 0, 1e-12);
      EXPECT_NEAR(s[2].z, -2 * mu, 1e-12);
    }
  }
}

TEST(SolutionError, StressOfAQuadraticFieldIsTheOneAtTheVertex) {
  const TetMesh mesh = build_kuhn_cube(3, 0.3, 2);
  const std::vector<Vec3> field = at_nodes(mesh, kQuadratic);
  for (Index v = 0; v < mesh.points.size(); v += 5) {
    const Vec3& x = mesh.points[v];
    const auto s = stress_at_vertex(mesh, field, v, 3.0, 2.0);
    // Gradient rows (y, x, 1), (-1, 0, 2 z), (-z, 2 y, -x).
    const double pressure = 3.0 * (x.y - x.x);
    EXPECT_NEAR(s[0].x, pressure + 4.0 * x.y, 1e-11);
    EXPECT_NEAR(s[1].y, pressure, 1e-11);
    EXPECT_NEAR(s[2].z, pressure - 4.0 * x.x, 1e-11);
    EXPECT_NEAR(s[0].y, 2.0 * (x.x - 1.0), 1e-11);
    EXPECT_NEAR(s[1].z, 4.0 * (x.z + x.y), 1e-11);
    EXPECT_NEAR(s[0].z, 2.0 * (1.0 - x.z), 1e-11);
  }
}

TEST(SolutionError, RefusesWhatItCannotCompare) {
  const TetMesh mesh = build_kuhn_cube(1, 0.0, 0);
  std::vector<Vec3> field(mesh.points.size());
  const FieldFunction zero = [](const Vec3&) { return Vec3{}; };
  EXPECT_THROW(compare_with_solution(mesh, field, zero), InputError);
  field[3].y = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(compare_with_solution(mesh, field, kLinear), InputError);
  field.pop_back();
  EXPECT_THROW(compare_with_solution(mesh, field, kLinear), ContractError);
  EXPECT_THROW(stress_at_vertex(mesh, field, 0, 1.0, 1.0), ContractError);
  field.resize(mesh.points.size());
  EXPECT_THROW(stress_at_vertex(mesh, field, 99, 1.0, 1.0), ContractError);
}

}  // namespace
}  // namespace palpate::judge

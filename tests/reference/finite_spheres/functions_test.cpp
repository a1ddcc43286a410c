// The spheres' functions: cover, unity, linear fields, gradients, continuity, and gaps that they do not
// cross.
#include "reference/finite_spheres/functions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/dynamics/linear_algebra/matrix3.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "reference/finite_spheres/quadrature.h"
#include "tests/support/small_meshes.h"

namespace palpate::reference {
namespace {

constexpr Vec3 kShift{0.3, -0.2, 0.5};
constexpr dynamics::Mat3 kGradient{{0.7, -0.4, 0.2, 0.1, 0.9, -0.3, -0.6, 0.5, 0.8}};

Vec3 linear_field(const Vec3& x) {
  return kShift + kGradient * x;
}

/// The coefficient with which a function takes part in a linear field.
Vec3 coefficient(const Spheres& spheres, SphereFunctions kind, Index number) {
  if (kind == SphereFunctions::kLeastSquares) return linear_field(spheres.centres_m[number]);
  const Index sphere = number / 4;
  if (number % 4 == 0) return linear_field(spheres.centres_m[sphere]);
  const std::size_t axis = number % 4 - 1;
  return spheres.radii_m[sphere] * Vec3{kGradient(0, axis), kGradient(1, axis), kGradient(2, axis)};
}

/// How far the functions at a point are from unity, from linear_field and from its gradient, at most.
double reproduction_error(const Spheres& spheres, SphereFunctions kind, const Vec3& at,
                          const FunctionValues& here) {
  Vec3 value;
  dynamics::Mat3 gradient;
  double unity = 0.0;
  Vec3 unity_gradient;
  for (std::size_t i = 0; i < here.numbers.size(); ++i) {
    const Vec3 a = coefficient(spheres, kind, here.numbers[i]);
    value = value + here.values[i] * a;
    dynamics::add_outer(gradient, a, here.gradients[i]);
    if (kind == SphereFunctions::kShepard && here.numbers[i] % 4 != 0) continue;
    unity += here.values[i];
    unity_gradient = unity_gradient + here.gradients[i];
  }
  const dynamics::Mat3 off = gradient - kGradient;
  return std::max({std::fabs(unity - 1.0), length(unity_gradient), length(value - linear_field(at)),
                   std::sqrt(dynamics::contract(off, off))});
}

/// A point inside a tet; no coordinate is below `least`.
std::array<double, 4> draw_inside(SplitMix64& random, double least) {
  std::array<double, 4> at{};
  double sum = 0.0;
  for (double& l : at) sum += l = -std::log(1.0 - random.uniform());
  for (double& l : at) l = least + (1.0 - 4.0 * least) * l / sum;
  return at;
}

Vec3 place_of(const TetMesh& mesh, std::size_t tet, const std::array<double, 4>& at) {
  Vec3 sum;
  for (std::size_t i = 0; i < 4; ++i) sum = sum + at[i] * mesh.points[mesh.tets[tet][i]];
  return sum;
}

class SphereFunctionsOf : public testing::TestWithParam<SphereFunctions> {};

TEST_P(SphereFunctionsOf, AreUnityAndReproduceLinearFieldsToRounding) {
  const TetMesh mesh = build_kuhn_cube(3, 0.3, 7);
  SplitMix64 random(11);
  FunctionValues here;
  for (const double factor : {1.05, 1.3, 2.2}) {
    const Spheres spheres = build_spheres(mesh, factor);
    Vec3 at;
    for (int draw = 0; draw < 400; ++draw) {
      const std::size_t tet = random.below(mesh.tets.size());
      at = place_of(mesh, tet, draw_inside(random, 0.0));
      evaluate_functions(spheres, GetParam(), tet, at, here);
      // Near a vertex the other corners' weights are w(1 / 1.05) = 4e-4 at least, which bounds the condition
      // of the moments by some 1e5; gradients are longer by 1 / r < 10.
      ASSERT_LT(reproduction_error(spheres, GetParam(), at, here), 1e-10)
          << "factor " << factor << " tet " << tet;
    }
    here.values[0] += 1e-3;
    EXPECT_GT(reproduction_error(spheres, GetParam(), at, here), 1e-4)
        << "a function that is off must be seen";
  }
}

TEST_P(SphereFunctionsOf, HaveTheGradientsOfTheirDifferences) {
  const TetMesh mesh = build_kuhn_cube(3, 0.3, 7);
  const Spheres spheres = build_spheres(mesh, 1.4);
  SplitMix64 random(12);
  FunctionValues here;
  FunctionValues beside;
  const double h = 1e-4;
  for (int draw = 0; draw < 60; ++draw) {
    const std::size_t tet = random.below(mesh.tets.size());
    const Vec3 at = place_of(mesh, tet, draw_inside(random, 0.05));
    evaluate_functions(spheres, GetParam(), tet, at, here);
    std::map<Index, std::array<double, 3>> slope;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (const double sign : {1.0, -1.0}) {
        const std::array<double, 3> by{axis == 0 ? sign * h : 0.0, axis == 1 ? sign * h : 0.0,
                                       axis == 2 ? sign * h : 0.0};
        evaluate_functions(spheres, GetParam(), tet, at + Vec3{by[0], by[1], by[2]}, beside);
        for (std::size_t i = 0; i < beside.numbers.size(); ++i)
          slope[beside.numbers[i]][axis] += sign * beside.values[i] / (2.0 * h);
      }
    }
    // Third derivatives of functions that fall from 1 to 0 within r > 0.3 are of the order 100 / r^3 < 1e4.
    for (std::size_t i = 0; i < here.numbers.size(); ++i) {
      const std::array<double, 3>& s = slope[here.numbers[i]];
      ASSERT_LT(length(here.gradients[i] - Vec3{s[0], s[1], s[2]}), 1e4 * h * h)
          << "function " << here.numbers[i];
    }
  }
}

/// The functions at a point, by number.
std::map<Index, double> values_at(const Spheres& spheres, SphereFunctions kind, std::size_t tet,
                                  const Vec3& at) {
  FunctionValues here;
  evaluate_functions(spheres, kind, tet, at, here);
  std::map<Index, double> values;
  for (std::size_t i = 0; i < here.numbers.size(); ++i) values[here.numbers[i]] = here.values[i];
  return values;
}

/// Two arms, 0.1 apart, that meet at x < 1.
TetMesh make_clamp() {
  std::vector<testing_support::Cell> cells{{0, 1, 0}};
  for (int x = 0; x < 5; ++x) {
    cells.push_back({x, 0, 0});
    cells.push_back({x, 2, 0});
  }
  TetMesh mesh = testing_support::make_kuhn_cells(cells);
  for (Vec3& p : mesh.points) {
    if (p.y > 1.5) p.y -= 0.9;
  }
  return mesh;
}

TEST_P(SphereFunctionsOf, AreContinuousAcrossFaces) {
  for (const TetMesh& mesh : {make_clamp(), build_kuhn_cube(3, 0.3, 7)}) {
    const Spheres spheres = build_spheres(mesh, 1.6);
    for (const Face& face : build_faces(mesh)) {
      if (face.tets[1] == kNoIndex) continue;
      const auto& p = mesh.points;
      const Vec3 at = 0.5 * p[face.vertices[0]] + 0.3 * p[face.vertices[1]] + 0.2 * p[face.vertices[2]];
      std::map<Index, double> first = values_at(spheres, GetParam(), face.tets[0], at);
      for (const auto& [number, value] : values_at(spheres, GetParam(), face.tets[1], at))
        first[number] -= value;
      for (const auto& [number, difference] : first)
        ASSERT_NEAR(difference, 0.0, 1e-12) << "function " << number;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(BothKinds, SphereFunctionsOf,
                         testing::Values(SphereFunctions::kLeastSquares, SphereFunctions::kShepard),
                         [](const auto& each) { return std::string(kSphereFunctionNames.of(each.param)); });

TEST(Spheres, ReachNoFartherThanTheirPartOfTheBody) {
  const TetMesh mesh = make_clamp();
  const Spheres spheres = build_spheres(mesh, 1.2);
  std::size_t near_bend = 0;
  for (std::size_t tet = 0; tet < mesh.tets.size(); ++tet) {
    const Vec3 middle = place_of(mesh, tet, {0.25, 0.25, 0.25, 0.25});
    for (const Index sphere : spheres.of(tet)) {
      const Vec3& centre = spheres.centres_m[sphere];
      const bool is_across = (middle.y < 1.0 && centre.y > 1.05) || (middle.y > 1.1 && centre.y < 1.05);
      if (!is_across) continue;
      // A way around the bend leaves the sphere where its centre is farther from x = 1 than its radius.
      ASSERT_LT(centre.x - 1.0, spheres.radii_m[sphere]) << "sphere " << sphere << " tet " << tet;
      ++near_bend;
    }
  }
  EXPECT_GT(near_bend, 0U);  // and around the bend, where the body is connected, they do
}

TEST(Spheres, EachTetIsReachedByItsCorners) {
  const TetMesh mesh = build_kuhn_cube(4, 0.4, 9);
  const Spheres spheres = build_spheres(mesh, 1.01);
  for (std::size_t tet = 0; tet < mesh.tets.size(); ++tet) {
    const auto members = spheres.of(tet);
    ASSERT_TRUE(std::is_sorted(members.begin(), members.end()));
    for (const Index corner : mesh.tets[tet]) {
      ASSERT_TRUE(std::binary_search(members.begin(), members.end(), corner));
      for (const Index other : mesh.tets[tet])
        ASSERT_LT(length(mesh.points[corner] - mesh.points[other]), spheres.radii_m[corner]);
    }
  }
  EXPECT_THROW(build_spheres(mesh, 1.0), ContractError);
}

TEST(Spheres, RefuseAFlatTet) {
  TetMesh mesh = testing_support::make_corner_tet();
  mesh.points[3] = {0.3, 0.3, 1e-14};
  const Spheres spheres = build_spheres(mesh, 1.2);
  FunctionValues here;
  EXPECT_THROW(evaluate_functions(spheres, SphereFunctions::kLeastSquares, 0, {0.3, 0.3, 0.0}, here),
               InputError);
}

TEST(Spheres, WeightIsTheQuarticSpline) {
  for (int k = 0; k <= 20; ++k) {
    const double s = k / 20.0;
    EXPECT_NEAR(quartic_spline(s), 1.0 - 6.0 * s * s + 8.0 * s * s * s - 3.0 * s * s * s * s, 1e-14);
  }
  EXPECT_EQ(quartic_spline(1.0), 0.0);
  EXPECT_EQ(quartic_spline(1.5), 0.0);
}

/// The mean of l_1^a l_2^b l_3^c over a tet, 6 a! b! c! / (a + b + c + 3)!.
double mean_of_monomial(int a, int b, int c) {
  return 6.0 * std::tgamma(a + 1.0) * std::tgamma(b + 1.0) * std::tgamma(c + 1.0) /
         std::tgamma(a + b + c + 4.0);
}

/// How far a rule is from exact on the monomials of a degree, at most.
double rule_error(const std::vector<TetPoint>& rule, int degree) {
  double most = 0.0;
  for (int a = 0; a <= degree; ++a) {
    for (int b = 0; a + b <= degree; ++b) {
      const int c = degree - a - b;
      double sum = 0.0;
      for (const TetPoint& p : rule)
        sum += p.weight * std::pow(p.at[1], a) * std::pow(p.at[2], b) * std::pow(p.at[3], c);
      most = std::max(most, std::fabs(sum - mean_of_monomial(a, b, c)));
    }
  }
  return most;
}

TEST(SphereQuadrature, TetRulesHaveTheirDegreeAndNoMore) {
  const std::map<int, int> degree_of{{1, 1}, {4, 2}, {14, 5}};
  for (const auto& [points, exact] : degree_of) {
    for (int subdivide = 0; subdivide <= 1; ++subdivide) {
      const std::vector<TetPoint> rule = build_tet_rule(points, subdivide);
      EXPECT_EQ(rule.size(), static_cast<std::size_t>(points) * (subdivide == 0 ? 1U : 8U));
      for (int degree = 0; degree <= exact; ++degree) EXPECT_LT(rule_error(rule, degree), 1e-14) << points;
      EXPECT_GT(rule_error(rule, exact + 1), 1e-8) << points;
      for (const TetPoint& p : rule) {
        EXPECT_GT(p.weight, 0.0);
        for (const double l : p.at) EXPECT_GT(l, 0.0);
      }
    }
  }
  EXPECT_THROW(build_tet_rule(11, 0), InputError);
}

/// The same over a face: the mean is 2 a! b! / (a + b + 2)!.
double face_rule_error(const std::vector<FacePoint>& rule, int degree) {
  double most = 0.0;
  for (int a = 0; a <= degree; ++a) {
    const int b = degree - a;
    double sum = 0.0;
    for (const FacePoint& p : rule) sum += p.weight * std::pow(p.at[1], a) * std::pow(p.at[2], b);
    const double exact = 2.0 * std::tgamma(a + 1.0) * std::tgamma(b + 1.0) / std::tgamma(a + b + 3.0);
    most = std::max(most, std::fabs(sum - exact));
  }
  return most;
}

TEST(SphereQuadrature, FaceRulesHaveTheirDegreeAndNoMore) {
  for (int subdivide = 0; subdivide <= 2; ++subdivide) {
    const std::vector<FacePoint> rule = build_face_rule(subdivide);
    for (int degree = 0; degree <= 5; ++degree) EXPECT_LT(face_rule_error(rule, degree), 1e-14);
    if (subdivide == 0) {
      EXPECT_GT(face_rule_error(rule, 6), 1e-8);
    }
  }
  const std::vector<FacePoint> dual = build_dual_face_rule();
  EXPECT_LT(face_rule_error(dual, 1), 1e-14);
  EXPECT_GT(face_rule_error(dual, 2), 1e-4);
  for (std::size_t p = 0; p < dual.size(); ++p) {  // each point is nearest to the corner that it belongs to
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_LE(dual[p].at[i], dual[p].at[static_cast<std::size_t>(kDualFaceCorner[p])]);
  }
}

}  // namespace
}  // namespace palpate::reference

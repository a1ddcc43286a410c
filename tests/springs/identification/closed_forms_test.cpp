#include "core/springs/identification/closed_forms.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/mesh/geometry.h"
#include "core/mesh/shapes/shapes.h"
#include "core/springs/network/network.h"
#include "tests/support/small_meshes.h"

namespace palpate::springs {
namespace {

using namespace testing_support;

constexpr double kYoung = 12000.0;

/// sum of k l^2 / (6 E V): 1 by the master identity of isotropic networks.
double master_ratio(const TetMesh& mesh, const SpringNetwork& network) {
  double sum = 0.0;
  for (std::size_t s = 0; s < network.springs.size(); ++s)
    sum += network.stiffness_n_per_m[s] * network.rest_length_m[s] * network.rest_length_m[s];
  return sum / (6.0 * kYoung * total_volume(mesh));
}

TEST(ClosedForms, UniformIsWhatWasGivenOrMeetsTheMasterIdentity) {
  const TetMesh mesh = build_kuhn_cube(3, 0.2, 1);
  SpringNetwork network = build_spring_network(mesh);
  set_uniform(mesh, kYoung, 42.5, network);
  EXPECT_EQ(network.stiffness_n_per_m, std::vector<double>(network.springs.size(), 42.5));
  set_uniform(mesh, kYoung, std::nullopt, network);
  EXPECT_EQ(network.stiffness_n_per_m.front(), network.stiffness_n_per_m.back());
  EXPECT_NEAR(master_ratio(mesh, network), 1.0, 1e-13);
}

TEST(ClosedForms, VanGelderMeetsTheMasterIdentityOnAnyMesh) {
  for (const TetMesh& mesh : {make_corner_tet(), build_kuhn_cube(3, 0.3, 2), build_bcc_bar(2)}) {
    SpringNetwork network = build_spring_network(mesh);
    set_van_gelder(mesh, kYoung, network);
    EXPECT_NEAR(master_ratio(mesh, network), 1.0, 1e-13);
  }
  // One regular tet of edge 1: k = E V = E / (6 sqrt 2).
  SpringNetwork one = build_spring_network(make_regular_tet());
  set_van_gelder(make_regular_tet(), kYoung, one);
  for (const double k : one.stiffness_n_per_m) EXPECT_NEAR(k, kYoung / (6.0 * std::sqrt(2.0)), 1e-9);
}

TEST(ClosedForms, LloydIsTwoRootTwoOver25TimesTheEdgeOfTheRegularTet) {
  const TetMesh regular = make_regular_tet();
  SpringNetwork network = build_spring_network(regular);
  set_lloyd(regular, kYoung, network);
  for (const double k : network.stiffness_n_per_m)
    EXPECT_NEAR(k, 2.0 * std::sqrt(2.0) / 25.0 * kYoung, 1e-9);  // edge 1
  EXPECT_NEAR(master_ratio(regular, network), 0.96, 1e-13);
  // The general form (sqrt 2 / 15) (lambda + 2 mu) l at Poisson's ratio 1/4, where lambda = mu = 0.4 E.
  EXPECT_NEAR(network.stiffness_n_per_m[0], std::sqrt(2.0) / 15.0 * 1.2 * kYoung, 1e-9);
}

TEST(ClosedForms, LloydAddsUpOverTheTetsAroundAnEdge) {
  const TetMesh two = make_two_tets();
  SpringNetwork network = build_spring_network(two);
  set_lloyd(two, kYoung, network);
  const auto tet_springs = build_tet_springs(two, network);
  const auto edge_of = [&](const Tet& t) {
    return std::cbrt(6.0 * std::sqrt(2.0) *
                     signed_volume(two.points[t[0]], two.points[t[1]], two.points[t[2]], two.points[t[3]]));
  };
  std::vector<double> expected(network.springs.size(), 0.0);
  for (std::size_t t = 0; t < 2; ++t) {
    for (const Index s : tet_springs[t])
      expected[s] += 2.0 * std::sqrt(2.0) / 25.0 * kYoung * edge_of(two.tets[t]);
  }
  for (std::size_t s = 0; s < expected.size(); ++s)
    EXPECT_NEAR(network.stiffness_n_per_m[s], expected[s], 1e-9);
}

TEST(ClosedForms, MacielIsHalfAsStiffAsTheSolidOnRegularTetsAndMoreOnOthers) {
  const TetMesh regular = make_regular_tet();
  SpringNetwork network = build_spring_network(regular);
  set_maciel(regular, kYoung, network);
  EXPECT_NEAR(master_ratio(regular, network), 0.5, 1e-13);
  const TetMesh mesh = build_kuhn_cube(3, 0.3, 4);
  SpringNetwork other = build_spring_network(mesh);
  set_maciel(mesh, kYoung, other);
  EXPECT_GT(master_ratio(mesh, other), 0.5);
}

TEST(ClosedForms, MacielSectionsAreTheInterfacesOfTheInfluenceVolumes) {
  // In the corner tet, the barycentric dual face of edge 0-x is the kite (1/2,0,0), (1/3,1/3,0),
  // (1/4,1/4,1/4), (1/3,0,1/3).
  const TetMesh tet = make_corner_tet();
  SpringNetwork network = build_spring_network(tet);
  set_maciel(tet, kYoung, network);
  const Vec3 m{0.5, 0, 0};
  const Vec3 f{1.0 / 3, 1.0 / 3, 0};
  const Vec3 g{0.25, 0.25, 0.25};
  const Vec3 h{1.0 / 3, 0, 1.0 / 3};
  const double area = 0.5 * (length(cross(f - m, g - m)) + length(cross(g - m, h - m)));
  ASSERT_EQ(network.springs[0], (Edge{0, 1}));
  EXPECT_NEAR(network.stiffness_n_per_m[0], kYoung * area, 1e-9);  // l = 1
}

TEST(ClosedForms, DoublingTheSizeDoublesTheStiffness) {
  const TetMesh small = build_kuhn_cube(2, 0.2, 8);
  TetMesh big = small;
  for (Vec3& p : big.points) p = 2.0 * p;
  const auto check = [&](auto&& set) {
    SpringNetwork a = build_spring_network(small);
    SpringNetwork b = build_spring_network(big);
    set(small, a);
    set(big, b);
    for (std::size_t s = 0; s < a.springs.size(); ++s)
      EXPECT_NEAR(b.stiffness_n_per_m[s], 2.0 * a.stiffness_n_per_m[s], 1e-12 * b.stiffness_n_per_m[s]);
  };
  check([](const TetMesh& mesh, SpringNetwork& n) { set_uniform(mesh, kYoung, std::nullopt, n); });
  check([](const TetMesh& mesh, SpringNetwork& n) { set_van_gelder(mesh, kYoung, n); });
  check([](const TetMesh& mesh, SpringNetwork& n) { set_lloyd(mesh, kYoung, n); });
  check([](const TetMesh& mesh, SpringNetwork& n) { set_maciel(mesh, kYoung, n); });
}

}  // namespace
}  // namespace palpate::springs

#include "core/dynamics/elasticity/strain_operator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/small_meshes.h"

namespace palpate::dynamics {
namespace {

constexpr std::array kDomains{StrainDomain::kTet, StrainDomain::kFace, StrainDomain::kEdge,
                              StrainDomain::kNode};

TEST(StrainOperator, AnAffineFieldHasItsGradientInEveryDomain) {
  const TetMesh mesh = build_kuhn_cube(3, 0.3, 4);
  const Mat3 gradient{{0.1, 0.2, -0.3, 0.4, -0.5, 0.6, 0.7, 0.8, -0.9}};
  const std::vector<Vec3> u = testing_support::make_affine_field(mesh.points, gradient, {1.0, 2.0, 3.0});
  for (const StrainDomain domain : kDomains) {
    const StrainOperator op = build_strain_operator(mesh, domain);
    for (std::size_t s = 0; s < op.domains(); ++s) {
      const Mat3 off = displacement_gradient(op, s, u) - gradient;
      EXPECT_LT(std::sqrt(contract(off, off)), 1e-12) << strain_domain_name(domain);
    }
  }
}

TEST(StrainOperator, VolumesAddUpAndDomainsAreTheMeshs) {
  const TetMesh mesh = build_kuhn_cube(3, 0.3, 4);
  const std::array counts{mesh.tets.size(), build_faces(mesh).size(), build_edges(mesh).size(),
                          mesh.points.size()};
  for (std::size_t k = 0; k < kDomains.size(); ++k) {
    const StrainOperator op = build_strain_operator(mesh, kDomains[k]);
    EXPECT_EQ(op.domains(), counts[k]);
    EXPECT_NEAR(std::accumulate(op.volume_m3.begin(), op.volume_m3.end(), 0.0), total_volume(mesh), 1e-13);
  }
}

TEST(StrainOperator, ANodesGradientIsTheMeanOfItsTets) {
  const TetMesh mesh = build_kuhn_cube(2, 0.3, 9);
  const std::vector<Vec3> u = testing_support::make_random_field(mesh.points.size(), 1.0, 3);
  const StrainOperator tets = build_strain_operator(mesh, StrainDomain::kTet);
  const StrainOperator nodes = build_strain_operator(mesh, StrainDomain::kNode);
  const VertexStars stars = build_vertex_stars(mesh);
  for (Index v = 0; v < mesh.points.size(); ++v) {
    Mat3 sum;
    double volume = 0.0;
    for (const Index t : stars.of(v)) {
      sum += tets.volume_m3[t] * displacement_gradient(tets, t, u);
      volume += tets.volume_m3[t];
    }
    const Mat3 off = displacement_gradient(nodes, v, u) - (1.0 / volume) * sum;
    EXPECT_LT(std::sqrt(contract(off, off)), 1e-12);
  }
}

TEST(StrainOperator, EdgesAndFacesAreNumberedAsTheMeshDoes) {
  const TetMesh mesh = testing_support::make_two_tets();
  const std::vector<Face> faces = build_faces(mesh);
  const StrainOperator op = build_strain_operator(mesh, StrainDomain::kFace);
  for (std::size_t f = 0; f < faces.size(); ++f)
    EXPECT_EQ(op.vertices_of(f).size(), faces[f].tets[1] == kNoIndex ? 4U : 5U);
  const std::vector<Edge> edges = build_edges(mesh);
  const StrainOperator by_edge = build_strain_operator(mesh, StrainDomain::kEdge);
  for (std::size_t e = 0; e < edges.size(); ++e) {
    std::size_t around = 0;
    for (const Tet& tet : mesh.tets)
      around +=
          std::count(tet.begin(), tet.end(), edges[e][0]) * std::count(tet.begin(), tet.end(), edges[e][1]);
    EXPECT_EQ(by_edge.vertices_of(e).size(), around == 1 ? 4U : 5U);
  }
}

TEST(StrainOperator, ATetOfNoVolumeIsRefused) {
  TetMesh mesh = testing_support::make_regular_tet();
  std::swap(mesh.tets[0][0], mesh.tets[0][1]);
  EXPECT_THROW(build_strain_operator(mesh, StrainDomain::kNode), InputError);
}

TEST(StrainOperator, UnknownNamesAreRefused) {
  for (const StrainDomain domain : kDomains)
    EXPECT_EQ(parse_strain_domain(strain_domain_name(domain)), domain);
  EXPECT_THROW(parse_strain_domain("cell"), InputError);
}

}  // namespace
}  // namespace palpate::dynamics

#include "core/mesh/face_weights.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "core/mesh/geometry.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "tests/support/dynamics_cases.h"

namespace palpate {
namespace {

/// What a strip x <= 0.6 has of the faces of the unit cube's bottom, 4 x 4 x 2 triangles.
struct Strip {
  TetMesh mesh = build_kuhn_cube(4, 0.0, 0);
  std::vector<FaceCover> covers;

  Strip() {
    for (const Triangle& face : testing_support::find_faces_at(mesh, 2, 0.0)) {
      const Vec3& a = mesh.points[face[0]];
      const Vec3 ab = mesh.points[face[1]] - a;
      const Vec3 ac = mesh.points[face[2]] - a;
      FaceCover cover{face, 0.5 * length(cross(ab, ac)), 0.0, {}};
      for_each_part([&](double u, double v) {
        if ((a + u * ab + v * ac).x > 0.6) return;
        cover.share += 1.0 / kPartsOfFace;
        cover.corners[1] += u / kPartsOfFace;
        cover.corners[2] += v / kPartsOfFace;
      });
      cover.corners[0] = cover.share - cover.corners[1] - cover.corners[2];
      if (cover.share == 1.0) cover.corners.fill(1.0 / 3.0);
      if (cover.share > 0.0) covers.push_back(cover);
    }
  }

  /// What is missing at the vertices, the most of any of them.
  double most_missing(const std::vector<double>& weight) const {
    std::map<Index, double> missing;
    for (std::size_t f = 0; f < covers.size(); ++f) {
      for (std::size_t k = 0; k < 3; ++k)
        missing[covers[f].face[k]] += covers[f].area * (covers[f].corners[k] - weight[f] / 3.0);
    }
    double most = 0.0;
    for (const auto& [vertex, lack] : missing) most = std::max(most, std::fabs(lack));
    return most;
  }

  /// Integral of x.
  double first_moment(const std::vector<double>& weight) const {
    double sum = 0.0;
    for (std::size_t f = 0; f < covers.size(); ++f) {
      for (const Index v : covers[f].face) sum += covers[f].area * weight[f] * mesh.points[v].x / 3.0;
    }
    return sum;
  }

  double own_first_moment() const {
    double sum = 0.0;
    for (const FaceCover& cover : covers) {
      for (std::size_t k = 0; k < 3; ++k) sum += cover.area * cover.corners[k] * mesh.points[cover.face[k]].x;
    }
    return sum;
  }

  std::vector<double> shares() const {
    std::vector<double> out;
    for (const FaceCover& cover : covers) out.push_back(cover.share);
    return out;
  }
};

TEST(FaceWeights, LinearFunctionsFeelTheDensityWhereItIs) {
  const Strip strip;
  const std::vector<double> shares = strip.shares();
  const std::vector<double> weights = match_moments(strip.covers);
  ASSERT_EQ(weights.size(), shares.size());
  EXPECT_GE(*std::min_element(weights.begin(), weights.end()), 0.0);
  EXPECT_LT(strip.most_missing(weights), 0.25 * strip.most_missing(shares));
  // The strip's own, to the parts' 1/64; the means reach too far.
  const double exact = strip.own_first_moment();
  EXPECT_NEAR(exact, 0.5 * 0.6 * 0.6, 0.6 / 64.0);
  const double reach = strip.first_moment(shares) - exact;
  EXPECT_GT(reach, 0.02 * exact);
  EXPECT_LT(std::fabs(strip.first_moment(weights) - exact), 0.1 * reach);
}

TEST(FaceWeights, TheWholeIsKept) {
  const Strip strip;
  const std::vector<double> weights = match_moments(strip.covers);
  double wanted = 0.0;
  double given = 0.0;
  for (std::size_t f = 0; f < weights.size(); ++f) {
    wanted += strip.covers[f].area * strip.covers[f].share;
    given += strip.covers[f].area * weights[f];
  }
  EXPECT_NEAR(given, wanted, 1e-14);
}

TEST(FaceWeights, EvenDensitiesStayToTheBit) {
  Strip strip;
  double share = 0.1;
  for (FaceCover& cover : strip.covers) {
    cover.share = share = std::fmod(1.7 * share + 0.11, 1.0);
    cover.corners.fill(cover.share / 3.0);
  }
  EXPECT_EQ(match_moments(strip.covers), strip.shares());
  EXPECT_TRUE(match_moments({}).empty());
}

TEST(FaceWeights, AFaceByItselfKeepsItsShare) {
  const FaceCover corner{{0, 1, 2}, 2.0, 0.25, {0.25, 0.0, 0.0}};
  EXPECT_NEAR(match_moments(std::vector{corner}).front(), 0.25, 1e-15);
}

}  // namespace
}  // namespace palpate

// Linear elements with fields beside them, and the fields that samples are nearest to.
#include "core/dynamics/enriched/enriched_elements.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/dynamics/finite_elements/node_loads.h"
#include "core/dynamics/linear_algebra/vertex_field.h"
#include "core/dynamics/enriched/principal_fields.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "tests/support/finite_elements.h"

namespace palpate::dynamics {
namespace {

/// A cube on an elastic bed, in quadratic elements and in the linear functions among them.
class Enriched : public testing::Test {
 protected:
  Enriched() {
    add_support_stiffness(loads_, 2, whole_);
    add_support_pull(loads_, 2, force_);
    coarse_body_.stiffness = restrict_matrix(map_, space_, whole_);
    const std::vector<std::uint8_t> free(space_.nodes(), 0);
    const std::vector<std::uint8_t> coarse_free(mesh_.points.size(), 0);
    fine_ = std::make_unique<HeldElements>(body_, whole_, free, factor_simplicial);
    coarse_ =
        std::make_unique<HeldElements>(coarse_body_, coarse_body_.stiffness, coarse_free, factor_simplicial);
  }

  std::vector<Vec3> rest(std::span<const std::vector<Vec3>> fields) const {
    const EnrichedElements enriched(*coarse_, map_, whole_, fields);
    return enriched.rest_under(force_, std::vector<Vec3>(mesh_.points.size()));
  }
  std::vector<Vec3> truth() const { return fine_->rest_under(force_, std::vector<Vec3>(space_.nodes())); }
  double work(const std::vector<Vec3>& u) const { return dot_of(force_, u); }

  TetMesh mesh_ = test::irregular_cube();
  BoundaryProblem problem_ = test::supported_cube(mesh_, 0.01);
  ElementSpace space_ = build_element_space(mesh_, 2);
  ElementMatrices body_ = build_element_matrices(mesh_, space_, problem_.material);
  BlockMatrix whole_ = body_.stiffness;
  NodeLoads loads_ = build_node_loads(mesh_, space_, problem_, BodyForces::kInclude);
  std::vector<Vec3> force_ = loads_.force_n;
  NodeMap map_ = embed_linear(space_, mesh_.points.size(), {});
  ElementMatrices coarse_body_;
  std::unique_ptr<HeldElements> fine_;
  std::unique_ptr<HeldElements> coarse_;
};

TEST_F(Enriched, TheFieldThatIsMissingMakesTheAnswerExact) {
  const std::vector<Vec3> exact = truth();
  const std::vector<Vec3> linear = rest({});
  std::vector<Vec3> missing = exact;
  add_scaled(missing, -1.0, linear);
  EXPECT_GT(test::difference(linear, exact), 1e-3);
  const std::vector<std::vector<Vec3>> fields{missing};
  EXPECT_LT(test::difference(rest(fields), exact), 1e-9);
  // Any multiple, and with linear functions mixed in: the space is the same.
  std::vector<std::vector<Vec3>> other{exact};
  for (Vec3& v : other[0]) v = -3.0 * v;
  EXPECT_LT(test::difference(rest(other), exact), 1e-9);
  // The field of another place is not the one that is missing.
  std::rotate(missing.begin(), missing.begin() + 7, missing.end());
  const std::vector<std::vector<Vec3>> broken{missing};
  EXPECT_GT(test::difference(rest(broken), exact), 1e-4);
}

TEST_F(Enriched, EachFieldTakesTheWorkOfTheLoadsNearerToTheFinerSpace) {
  // Galerkin in nested spaces: f . u rises towards that of the finest.
  SplitMix64 random(3);
  std::vector<std::vector<Vec3>> fields;
  double before = work(rest(fields));
  const double most = work(truth());
  for (int k = 0; k < 6; ++k) {
    std::vector<Vec3> field(space_.nodes());
    for (Vec3& v : field) v = {random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
    fields.push_back(std::move(field));
    const double now = work(rest(fields));
    EXPECT_GT(now, before);
    EXPECT_LT(now, most);
    before = now;
  }
}

TEST_F(Enriched, FieldsThatDependOnEachOtherAreRefused) {
  const std::vector<Vec3> exact = truth();
  const std::vector<std::vector<Vec3>> twice{exact, exact};
  EXPECT_THROW(rest(twice), UnavailableError);
}

TEST(PrincipalFields, FindTheFieldsThatSamplesAreMadeOf) {
  // Samples of two orthogonal fields, the first three times as large as the second.
  const std::vector<Vec3> first{{1, 0, 0}, {0, 1, 0}, {0, 0, 0}};
  const std::vector<Vec3> second{{0, 0, 1}, {0, 0, 0}, {1, 0, 0}};
  std::vector<std::vector<Vec3>> samples;
  for (int k = 0; k < 8; ++k) {
    const double turn = 2.0 * std::numbers::pi * k / 8.0;
    std::vector<Vec3> sample(3);
    add_scaled(sample, 3.0 * std::cos(turn), first);
    add_scaled(sample, std::sin(turn), second);
    samples.push_back(sample);
  }
  const FieldProduct same = [](std::span<const Vec3> x, std::span<Vec3> y) {
    std::copy(x.begin(), x.end(), y.begin());
  };
  const PrincipalFields found = find_principal_fields(samples, same, 5);
  ASSERT_EQ(found.fields.size(), 2U) << "the samples have no more";
  EXPECT_NEAR(found.shares[0], 0.9, 1e-12);
  EXPECT_NEAR(found.shares[1], 0.1, 1e-12);
  EXPECT_NEAR(std::fabs(dot_of(found.fields[0], first)), std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(std::fabs(dot_of(found.fields[1], second)), std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(dot_of(found.fields[0], found.fields[0]), 1.0, 1e-12);
  EXPECT_NEAR(dot_of(found.fields[0], found.fields[1]), 0.0, 1e-12);
  EXPECT_EQ(find_principal_fields(samples, same, 1).fields.size(), 1U);
  EXPECT_TRUE(find_principal_fields({}, same, 3).fields.empty());
}

}  // namespace
}  // namespace palpate::dynamics

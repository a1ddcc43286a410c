#include "core/dynamics/linear_algebra/curvature_pairs.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "core/dynamics/linear_algebra/vertex_field.h"
#include "tests/support/dynamics_cases.h"

namespace palpate::dynamics {
namespace {

using namespace testing_support;

constexpr std::size_t kVertices = 4;  ///< twelve unknowns: more than the pairs can know

std::vector<Vec3> random_field(std::mt19937_64& random) {
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  std::vector<Vec3> field(kVertices);
  for (Vec3& at : field) at = {number(random), number(random), number(random)};
  return field;
}

/// A symmetric positive definite matrix that couples all: D + the sum of all times ones.
std::vector<Vec3> times_matrix(std::span<const Vec3> field) {
  double sum = 0.0;
  for (const Vec3& at : field) sum += at.x + at.y + at.z;
  std::vector<Vec3> product;
  double diagonal = 1.0;
  for (const Vec3& at : field) {
    product.push_back({diagonal * at.x + sum, (diagonal + 1.0) * at.y + sum, (diagonal + 2.0) * at.z + sum});
    diagonal += 3.0;
  }
  return product;
}

TEST(CurvaturePairs, TheLastPairIsKeptToAndTheMatrixStaysSymmetricAndPositive) {
  std::mt19937_64 random(7);
  CurvaturePairs pairs(kVertices);
  const auto scaled = [](std::span<Vec3> field) {
    for (Vec3& at : field) at = 0.3 * at;
  };
  for (int k = 0; k < 9; ++k) {  // more than are kept
    const std::vector<Vec3> s = random_field(random);
    const std::vector<Vec3> y = times_matrix(s);
    pairs.keep(s, y);
    std::vector<Vec3> found = y;
    pairs.apply(found, scaled);
    EXPECT_LT(field_distance(found, s), 1e-13 * field_norm(s)) << "H y = s";
    const std::vector<Vec3> a = random_field(random);
    const std::vector<Vec3> b = random_field(random);
    std::vector<Vec3> of_a = a;
    std::vector<Vec3> of_b = b;
    pairs.apply(of_a, scaled);
    pairs.apply(of_b, scaled);
    EXPECT_NEAR(dot_of(of_a, b), dot_of(of_b, a), 1e-12);
    EXPECT_GT(dot_of(of_a, a), 0.0);
  }
  pairs.clear();
  std::vector<Vec3> found = random_field(random);
  const std::vector<Vec3> given = found;
  pairs.apply(found, scaled);
  for (std::size_t v = 0; v < kVertices; ++v) EXPECT_EQ(found[v].x, 0.3 * given[v].x);
}

TEST(CurvaturePairs, WhatHasNoCurvatureIsLeftOut) {
  std::mt19937_64 random(8);
  CurvaturePairs pairs(kVertices);
  const std::vector<Vec3> s = random_field(random);
  std::vector<Vec3> y = s;
  for (Vec3& at : y) at = -1.0 * at;
  pairs.keep(s, y);
  EXPECT_TRUE(pairs.is_empty());
  y.front().x = std::nan("");
  pairs.keep(s, y);
  EXPECT_TRUE(pairs.is_empty());
  pairs.keep(s, s);
  EXPECT_FALSE(pairs.is_empty());
}

}  // namespace
}  // namespace palpate::dynamics

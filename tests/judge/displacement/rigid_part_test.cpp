#include "core/judge/displacement/rigid_part.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/judge/displacement/displacement.h"
#include "core/mesh/shapes/shapes.h"

namespace palpate::judge {
namespace {

Vec3 random_vector(SplitMix64& random) {
  const double x = random.uniform() - 0.5;
  const double y = random.uniform() - 0.5;
  return {x, y, random.uniform() - 0.5};
}

double weighted_dot(std::span<const double> weight, std::span<const Vec3> a, std::span<const Vec3> b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += weight[i] * dot(a[i], b[i]);
  return sum;
}

double size_of(std::span<const double> weight, std::span<const Vec3> field) {
  return std::sqrt(weighted_dot(weight, field, field));
}

std::vector<Vec3> rigid_field(std::span<const Vec3> points, const Vec3& translation, const Vec3& omega) {
  std::vector<Vec3> field;
  for (const Vec3& p : points) field.push_back(translation + cross(omega, p));
  return field;
}

class RigidParts : public testing::Test {
 protected:
  RigidParts() {
    for (Vec3& p : mesh_.points) p = {2.0 * p.x + 3.0, p.y - 1.0, 0.5 * p.z};
    weight_ = volume_shares(mesh_, mesh_.points.size());
    for (std::size_t i = 0; i < mesh_.points.size(); ++i) field_.push_back(random_vector(random_));
  }

  SplitMix64 random_{31};
  TetMesh mesh_ = build_kuhn_cube(3, 0.3, 3);
  std::vector<double> weight_;
  std::vector<Vec3> field_;
};

TEST_F(RigidParts, OfARigidMotionNothingIsLeft) {
  const std::vector<Vec3> rigid = rigid_field(mesh_.points, {1, -2, 0.5}, {0.3, 0.1, -0.7});
  const std::vector<Vec3> rest = without_rigid_motion(mesh_.points, weight_, rigid);
  EXPECT_LE(size_of(weight_, rest), 1e-14 * size_of(weight_, rigid));
}

// By the definition of a least-squares fit: what is left is orthogonal to all six motions.
TEST_F(RigidParts, WhatIsLeftIsOrthogonalToEachMotion) {
  const std::vector<Vec3> rest = without_rigid_motion(mesh_.points, weight_, field_);
  for (int k = 0; k < 6; ++k) {
    const Vec3 axis{k % 3 == 0 ? 1.0 : 0.0, k % 3 == 1 ? 1.0 : 0.0, k % 3 == 2 ? 1.0 : 0.0};
    const std::vector<Vec3> motion = rigid_field(mesh_.points, k < 3 ? axis : Vec3{}, k < 3 ? Vec3{} : axis);
    const double scale = size_of(weight_, motion) * size_of(weight_, field_);
    EXPECT_NEAR(weighted_dot(weight_, motion, rest), 0.0, 1e-14 * scale) << k;
  }
  EXPECT_LT(size_of(weight_, rest), size_of(weight_, field_));
}

TEST_F(RigidParts, AProjectionTakesNothingOffTwiceAndIsLinear) {
  const std::vector<Vec3> rest = without_rigid_motion(mesh_.points, weight_, field_);
  const std::vector<Vec3> again = without_rigid_motion(mesh_.points, weight_, rest);
  const std::vector<Vec3> rigid = rigid_field(mesh_.points, {5, 1, 2}, {1, 2, 3});
  std::vector<Vec3> sum = field_;
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = 2.0 * sum[i] + rigid[i];
  const std::vector<Vec3> of_sum = without_rigid_motion(mesh_.points, weight_, sum);
  for (std::size_t i = 0; i < rest.size(); ++i) {
    EXPECT_LE(length(again[i] - rest[i]), 1e-14);
    EXPECT_LE(length(of_sum[i] - 2.0 * rest[i]), 1e-12);
  }
}

// All weight on a line: turning about it moves nothing and must not divide by nothing.
TEST(RigidPart, OnALineOrAPointOnlyWhatMovesItIsTakenOff) {
  const std::vector<Vec3> line{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  const std::vector<Vec3> field{{1, 0, 0}, {1, 1, 2}, {1, 2, 4}};  // a shift and two turns
  for (const Vec3& u : without_rigid_motion(line, std::vector<double>{1, 1, 1}, field))
    EXPECT_LE(length(u), 1e-14);
  const std::vector<Vec3> point{{1, 2, 3}};
  EXPECT_LE(length(without_rigid_motion(point, std::vector<double>{2}, point)[0]), 1e-15);
  EXPECT_EQ(without_rigid_motion(point, std::vector<double>{0}, point)[0], point[0]);
  EXPECT_THROW(without_rigid_motion(point, std::vector<double>{}, point), ContractError);
}

// A swelling u = s p about the center has no rigid part: p x s p = 0. A shift hides it from the L2 error.
TEST(DeformationError, DoesNotSeeAShiftAndASmallErrorInItIsNotHidden) {
  TetMesh mesh = build_kuhn_cube(2, 0.0, 1);
  for (Vec3& p : mesh.points) p = p - Vec3{0.5, 0.5, 0.5};
  const auto stretched = [&](double s, double shift) {
    std::vector<Vec3> field;
    for (const Vec3& p : mesh.points) field.push_back(s * p + Vec3{shift, 0, 0});
    return field;
  };
  const std::vector<Vec3> truth = stretched(0.01, 1.0);
  const DisplacementError same = compare_displacement(mesh, stretched(0.01, 2.0), truth, 1.0, 1.0);
  EXPECT_NEAR(same.relative_deformation, 0.0, 1e-12);
  EXPECT_NEAR(same.relative_l2, 1.0, 1e-4);  // 1 over sqrt(1 + (0.01)^2 <p^2>)
  const DisplacementError half = compare_displacement(mesh, stretched(0.005, 1.0), truth, 1.0, 1.0);
  EXPECT_NEAR(half.relative_deformation, 0.5, 1e-11);
  EXPECT_LT(half.relative_l2, 0.005);
  EXPECT_GT(half.rigid_share, 0.999);
  EXPECT_NEAR(compare_displacement(mesh, stretched(0.02, 0), stretched(0.01, 0), 1, 1).rigid_share, 0.0,
              1e-12);
}

}  // namespace
}  // namespace palpate::judge

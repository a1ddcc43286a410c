// The lowest modes of chains and bodies that are known in closed form.
#include "core/dynamics/stability/lowest_modes.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.h"
#include "core/dynamics/motion/motion_forces.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/angles.h"
#include "tests/support/motion_cases.h"

namespace palpate::dynamics {
namespace {

using test::kPi;
using testing_support::make_free_body;
using testing_support::make_oscillator;

/// `count` masses of 1 kg in a row along x, springs of 1 N/m between them, the first held; all held sideways.
MotionModel make_chain(int count) {
  MotionModel model;
  model.elastic.springs_are_linear = true;
  Loads loads;
  for (int k = 0; k < count; ++k) {
    model.elastic.rest.push_back({static_cast<double>(k), 0.0, 0.0});
    loads.held.push_back(k == 0 ? 7 : 6);
    const auto v = static_cast<Index>(k);
    if (k == 0) continue;
    model.elastic.springs.springs.push_back({v - 1, v});
    model.elastic.springs.rest_length_m.push_back(1.0);
    model.elastic.springs.stiffness_n_per_m.push_back(1.0);
  }
  loads.force_n.resize(loads.held.size());
  loads.held_by_m.resize(loads.held.size());
  model.mass_kg.assign(loads.held.size(), 1.0);
  model.loads.push_back({loads, {}});
  return model;
}

// omega_k = 2 sin((2 k - 1) pi / (2 (2 n + 1))) for n free masses.
TEST(LowestModes, OfAChain) {
  const MotionModel model = make_chain(31);
  const NaturalModes found = find_lowest_modes(model, 10);
  ASSERT_TRUE(found.converged);
  ASSERT_EQ(found.frequency_hz.size(), 10U);
  for (std::size_t k = 0; k < 10; ++k) {
    const double omega = 2.0 * std::sin((2.0 * static_cast<double>(k) + 1.0) * kPi / (2.0 * 61.0));
    EXPECT_NEAR(found.frequency_hz[k], omega / (2.0 * kPi), 1e-10);
    double mass = 0.0;
    for (const Vec3& x : found.modes[k]) mass += length_sq(x);
    EXPECT_NEAR(mass, 1.0, 1e-10);
    EXPECT_EQ(found.modes[k][0], Vec3{});
    const ModeShares shares = measure_mode(model, found.modes[k]);
    EXPECT_NEAR(shares.stiffness, omega * omega, 1e-9);
    EXPECT_NEAR(shares.springs, omega * omega, 1e-9) << "springs of 1 N/m and 1 N s/m are the same matrix";
    EXPECT_NEAR(shares.vertices, 1.0, 1e-10);
  }
}

TEST(LowestModes, AFreeBodyHasSixAtZero) {
  const MotionModel model = make_free_body(build_kuhn_cube(3, 0.1, 5), 0.0);
  const NaturalModes found = find_lowest_modes(model, 8);
  ASSERT_TRUE(found.converged);
  for (std::size_t k = 0; k < 6; ++k) EXPECT_LT(found.frequency_hz[k], 1e-4 * found.frequency_hz[6]);
  EXPECT_LE(found.frequency_hz[6], found.frequency_hz[7]);
}

// A mode moves as a cosine: K x = omega^2 M x, vertex by vertex.
TEST(LowestModes, FulfilTheirEquation) {
  MotionModel model = make_free_body(build_kuhn_cube(3, 0.2, 9), 0.0, VolumeModel::kNodeAverage);
  for (std::size_t v = 0; v < model.mass_kg.size(); ++v)
    model.mass_kg[v] *= 1.0 + 0.3 * static_cast<double>(v % 5);
  const NaturalModes found = find_lowest_modes(model, 12);
  ASSERT_TRUE(found.converged);
  BlockMatrix stiffness = build_motion_pattern(model);
  add_motion_stiffness(model, std::vector<Vec3>(model.mass_kg.size()), TangentKind::kExact, stiffness);
  const std::vector<std::uint8_t> free(model.mass_kg.size());
  EXPECT_EQ(find_lowest_modes(stiffness, model.mass_kg, free, 12).frequency_hz, found.frequency_hz);
  for (std::size_t k = 6; k < 12; ++k) {
    const double omega_sq = std::pow(2.0 * kPi * found.frequency_hz[k], 2.0);
    std::vector<Vec3> force(model.mass_kg.size());
    multiply(stiffness, found.modes[k], force);
    double left = 0.0;
    double size = 0.0;
    for (std::size_t v = 0; v < force.size(); ++v) {
      left += length_sq(force[v] - omega_sq * model.mass_kg[v] * found.modes[k][v]);
      size += length_sq(force[v]);
    }
    EXPECT_LT(std::sqrt(left / size), 1e-6);
  }
}

TEST(LowestModes, RefusesMoreThanThereAre) {
  const MotionModel model = make_oscillator(3.0, 0.0);
  EXPECT_THROW(find_lowest_modes(model, 0), InputError);
  EXPECT_THROW(find_lowest_modes(model, 7), InputError);
}

}  // namespace
}  // namespace palpate::dynamics

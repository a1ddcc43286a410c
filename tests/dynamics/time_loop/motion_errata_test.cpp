// What the thesis says of damping, friction and the volume force and what is so; docs/errata.md names these
// tests.
#include <gtest/gtest.h>

#include <cmath>

#include "core/dynamics/elasticity/volume_force.h"
#include "core/mesh/geometry.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/motion_cases.h"

namespace palpate::dynamics {
namespace {

using namespace testing_support;

/// A free body without springs' forces that moves as a whole through its environment: m dv/dt = -gamma v,
/// gamma = 0.5 m.
MotionModel make_flying_body() {
  MotionModel flying = make_free_body(build_kuhn_cube(1, 0.0, 1), 0.0);
  for (const double mass : flying.mass_kg) flying.environment_damping_n_s_per_m.push_back(0.5 * mass);
  return flying;
}

/// The speed after `duration_s` of a body that starts with `speed` along x.
double speed_after(double speed, double duration_s, std::uint64_t steps) {
  const MotionModel flying = make_flying_body();
  MotionState start = start_at_rest(flying);
  for (Vec3& v : start.velocity_m_s) v = {speed, 0.0, 0.0};
  IntegratorOptions options;
  options.kind = IntegratorKind::kRungeKutta4;
  return march(flying, options, start, duration_s, steps).velocity_m_s[0].x;
}

TEST(MotionErrata, TheDampingOfEquation3_9AsPrintedDrivesInsteadOfBraking) {
  // m dv/dt = +gamma v has the solution exp(+t / 2), energy from nothing; with -gamma it is exp(-t / 2).
  const double after = speed_after(1.0, 2.0, 200);
  EXPECT_NEAR(after, std::exp(-1.0), 1e-10);
  EXPECT_GT(std::exp(1.0), 2.0 * 1.0);  // as printed the speed would more than double
  EXPECT_LT(after, 1.0);
}

TEST(MotionErrata, FrictionIsProportionalToTheVelocityNotInverselyProportional) {
  // What is lost in a short time doubles with the speed: a force c / v would halve it, and have no bound as
  // the body comes to rest, where 4.2.9 starts.
  const double slow = 1.0 - speed_after(1.0, 1e-3, 1);
  const double fast = 2.0 - speed_after(2.0, 1e-3, 1);
  EXPECT_NEAR(fast / slow, 2.0, 1e-9);
  EXPECT_NEAR(speed_after(1e-12, 1e-3, 1) / 1e-12, std::exp(-0.5e-3), 1e-9);
  EXPECT_EQ(speed_after(0.0, 1e-3, 1), 0.0);
}

TEST(MotionErrata, TheVolumeForceAsPrintedPushesAGrownOrganFurtherOut) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 3);
  const VolumeForce volume_force = build_volume_force(mesh, 100.0, 1.0);
  Vec3 center;
  for (std::size_t v = 0; v < mesh.points.size(); ++v)
    center = center + volume_force.center_weights[v] * mesh.points[v];
  for (const double growth : {0.02, -0.02}) {
    std::vector<Vec3> u(mesh.points.size());
    for (std::size_t v = 0; v < u.size(); ++v) u[v] = growth * (mesh.points[v] - center);
    std::vector<Vec3> ours(u.size());
    add_volume_force(volume_force, mesh.points, u, ours);
    const double vol_diff = (std::pow(1.0 + growth, 3) - 1.0) * total_volume(mesh);  // new - original
    double power_printed = 0.0;
    double power_ours = 0.0;
    for (std::size_t v = 0; v < u.size(); ++v) {
      // "in the direction opposite to the direction of a vector from vertex to the current barycenter"
      const Vec3 to_center = center - mesh.points[v];  // a dilation about the center leaves its direction
      const double distance = length(to_center);
      const Vec3 printed = (-volume_force.stiffness_n_per_m3 * vol_diff / distance) * to_center;
      EXPECT_LT(length(ours[v] + printed), 1e-9 * length(printed));  // ours is its opposite
      power_printed += dot(printed, u[v]);
      power_ours += dot(ours[v], u[v]);
    }
    EXPECT_GT(power_printed, 0.0) << growth;  // with the growth as with the shrinking: away from rest
    EXPECT_LT(power_ours, 0.0) << growth;
  }
}

}  // namespace
}  // namespace palpate::dynamics

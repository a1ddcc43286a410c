// Every build moves a small network alike: each is held to the same motion, which plain_reference.py computed
// in 40 digits. So release and debug differ by at most twice the tolerances here.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/base/random.h"
#include "core/dynamics/integrators/integrator.h"
#include "core/dynamics/spring_engine/plain_engine.h"

namespace palpate::dynamics {
namespace {

constexpr std::size_t kPoints = 80;
constexpr std::uint64_t kSteps = 500;
constexpr double kStep = 0.002;

struct Expected {
  std::size_t vertex;
  Vec3 displacement_m;
  Vec3 velocity_m_s;
};

constexpr std::array<Expected, 4> kExpected{{
    {0,
     {0.38902286436511110, -0.034160424315969916, 0.12982894154192782},
     {0.041324792466022503, -0.28912156507898080, 0.55482264932246545}},
    {17,
     {-0.31595540223292863, 0.081179218047789381, -0.13167761189725174},
     {-0.47338888889238096, 0.22117210060511304, 0.061139214183324844}},
    {41,
     {0.21634319663035415, -0.055119067968369938, -0.35330325151579123},
     {0.094002056486636712, -0.096718969955581562, 0.078572205704593957}},
    {79,
     {-0.034895002873008478, 0.25906730118986408, 0.050352216059864291},
     {-0.051356584313382401, 0.038299829978186673, -0.12175059469472725}},
}};

struct Network {
  MotionModel model;
  MotionState start;
};

/// As plain_reference.py draws it.
Network draw_network() {
  SplitMix64 random(42);
  Network out;
  std::vector<Vec3>& points = out.model.elastic.rest;
  const auto draw = [&](double low) {
    Vec3 v;
    for (double* const c : {&v.x, &v.y, &v.z}) *c = random.uniform() + low;
    return v;
  };
  for (std::size_t i = 0; i < kPoints; ++i) points.push_back(draw(0.0));
  SpringNetwork& net = out.model.elastic.springs;
  for (std::size_t i = 0; i < kPoints; ++i) {
    for (const std::size_t j : {i + 1, i + 2, i + 7, i + 31}) {
      if (j >= kPoints) continue;
      net.springs.push_back({static_cast<Index>(i), static_cast<Index>(j)});
      net.stiffness_n_per_m.push_back(5.0 + 10.0 * random.uniform());
      net.rest_length_m.push_back((0.8 + 0.4 * random.uniform()) * length(points[j] - points[i]));
      out.model.spring_damping_n_s_per_m.push_back(0.02 * net.stiffness_n_per_m.back());
    }
  }
  for (std::size_t i = 0; i < kPoints; ++i) out.model.mass_kg.push_back(0.1 + 0.1 * random.uniform());
  for (const double mass : out.model.mass_kg) out.model.environment_damping_n_s_per_m.push_back(0.05 * mass);
  out.start = start_at_rest(out.model);
  for (Vec3& v : out.start.velocity_m_s) v = draw(-0.5);
  return out;
}

/// The greatest distance from the expected displacements and velocities.
double farthest(const MotionState& found) {
  double most = 0.0;
  for (const Expected& each : kExpected) {
    most = std::max({most, length(found.displacement_m[each.vertex] - each.displacement_m),
                     length(found.velocity_m_s[each.vertex] - each.velocity_m_s)});
  }
  return most;
}

template <typename Real>
MotionState run_network(const Network& network, bool portable) {
  PlainOptions options;
  options.portable = portable;
  PlainEngine<Real> engine(network.model, options);
  engine.set_state(network.start);
  engine.step(kStep, kSteps);
  return engine.state();
}

TEST(PlainReference, DoublePrecisionIsWithin1e12InEveryBuild) {
  const Network network = draw_network();
  // Positions of size 1 are rounded to 1.1e-16 in each of 500 steps; strong springs enlarge that tenfold.
  EXPECT_LT(farthest(run_network<double>(network, true)), 1e-12);
  Integrator integrator(network.model, {});
  MotionState state = network.start;
  for (std::uint64_t k = 0; k < kSteps; ++k) integrator.step(state, kStep);
  EXPECT_LT(farthest(state), 1e-12);
}

TEST(PlainReference, SinglePrecisionIsWithin1e4InEveryBuild) {
  const Network network = draw_network();
  // The same with 6e-8: 3e-5, and room for what strong springs add.
  EXPECT_LT(farthest(run_network<float>(network, false)), 1e-4);
  EXPECT_LT(farthest(run_network<float>(network, true)), 1e-4);
}

TEST(PlainReference, AStepThatIsOffIsFound) {
  const Network network = draw_network();
  PlainEngine<double> engine(network.model, {});
  engine.set_state(network.start);
  engine.step(kStep * (1.0 + 1e-9), kSteps);
  EXPECT_GT(farthest(engine.state()), 1e-11);
}

}  // namespace
}  // namespace palpate::dynamics

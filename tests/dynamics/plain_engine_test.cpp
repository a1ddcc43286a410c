#include "core/dynamics/plain_engine.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/dynamics/integrator.h"
#include "core/dynamics/lanes.h"
#include "core/dynamics/plain_layout.h"
#include "core/mesh/shapes.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/motion_cases.h"

namespace palpate::dynamics {
namespace {

using namespace testing_support;

/// A cube of 2744 vertices, two blocks, held below, heavy, damped and shaken.
struct Shaken {
  MotionModel model;
  MotionState start;
};

Shaken make_shaken(SpringDamping damping = SpringDamping::kAxial) {
  const TetMesh mesh = build_kuhn_cube(13, 0.2, 5);
  Shaken out{make_pressed_body(mesh, 1.0), {}};
  out.model.loads.pop_back();
  out.model.spring_damping = damping;
  out.start = start_at_rest(out.model);
  out.start.velocity_m_s = make_random_field(mesh.points.size(), 0.1, 3);
  MotionForces forces(out.model, 1);
  forces.impose(0.0, out.start.displacement_m, out.start.velocity_m_s);
  return out;
}

template <typename Real>
MotionState run_plain(const Shaken& body, const PlainOptions& options, double step, std::uint64_t steps,
                      PlainReport* report = nullptr) {
  PlainEngine<Real> engine(body.model, options);
  engine.set_state(body.start);
  const PlainReport here = engine.step(step, steps);
  if (report != nullptr) *report = here;
  return engine.state();
}

TEST(PlainEngine, IsSymplecticEulerOfTheSameSprings) {
  const Shaken body = make_shaken();
  const double step = 1e-3;
  const MotionState expected = march(body.model, {}, body.start, 0.2, 200);
  const MotionState with_double = run_plain<double>(body, {}, step, 200);
  const MotionState with_float = run_plain<float>(body, {}, step, 200);
  const double size = field_norm(expected.displacement_m);
  // Rounding of positions of size 1, a few hundred times, against displacements of some hundredths.
  EXPECT_LT(field_distance(with_double.displacement_m, expected.displacement_m), 1e-12 * size);
  EXPECT_LT(field_distance(with_float.displacement_m, expected.displacement_m), 1e-3 * size);
  EXPECT_LT(field_distance(with_double.velocity_m_s, expected.velocity_m_s),
            1e-12 * field_norm(expected.velocity_m_s));
  EXPECT_NEAR(with_double.time_s, expected.time_s, 1e-12);
}

TEST(PlainEngine, OneThreadAndTwoGiveTheSameBits) {
  const Shaken body = make_shaken();
  EXPECT_EQ(hash_state(run_plain<float>(body, {1}, 1e-3, 20)),
            hash_state(run_plain<float>(body, {2}, 1e-3, 20)));
  EXPECT_EQ(hash_state(run_plain<double>(body, {1}, 1e-3, 20)),
            hash_state(run_plain<double>(body, {3}, 1e-3, 20)));
  EXPECT_NE(hash_state(run_plain<double>(body, {1}, 1e-3, 20)),
            hash_state(run_plain<double>(body, {1}, 1e-3, 21)));
}

TEST(PlainEngine, TheSpeedLimitIsThatOfTheIntegrator) {
  const Shaken body = make_shaken();
  IntegratorOptions slow;
  slow.speed_limit_m_s = 0.05;
  Integrator integrator(body.model, slow);
  MotionState expected = body.start;
  std::uint64_t cut = 0;
  for (int k = 0; k < 20; ++k) cut += integrator.step(expected, 1e-3).speeds_cut;
  PlainReport report;
  const MotionState got = run_plain<double>(body, {2, 0.05}, 1e-3, 20, &report);
  EXPECT_GT(cut, 0U);
  EXPECT_EQ(report.speeds_cut, cut);
  EXPECT_LT(field_distance(got.velocity_m_s, expected.velocity_m_s),
            1e-12 * field_norm(expected.velocity_m_s));
}

TEST(PlainEngine, ASpringWithoutLengthIsNoticedAndGivesNoForce) {
  Shaken body{make_oscillator(3.0, 0.1), {}};
  body.start = start_at_rest(body.model);
  body.start.displacement_m[1].x = -1.0;
  PlainReport report;
  const MotionState end = run_plain<double>(body, {}, 1e-3, 5, &report);
  EXPECT_EQ(report.steps_with_zero_length, 5U);
  EXPECT_EQ(end.displacement_m[1].x, -1.0);
  body.start.displacement_m[1].x = -0.5;
  run_plain<double>(body, {}, 1e-3, 5, &report);
  EXPECT_EQ(report.steps_with_zero_length, 0U);
}

TEST(PlainEngine, RefusesWhatItCannotDo) {
  EXPECT_THROW(PlainEngine<double>(make_shaken(SpringDamping::kIsotropic).model, {}), InputError);
  const TetMesh mesh = build_kuhn_cube(1, 0.0, 1);
  EXPECT_THROW(PlainEngine<float>(make_free_body(mesh, 0.0, VolumeModel::kNodeAverage), {}), InputError);
  EXPECT_THROW(PlainEngine<float>(make_free_body(mesh, 0.0, VolumeModel::kThesis), {}), InputError);
  EXPECT_THROW(PlainEngine<float>(make_pressed_body(mesh, 1.0), {}), InputError);
  MotionModel linear = make_free_body(mesh, 0.0);
  linear.elastic.springs_are_linear = true;
  EXPECT_THROW(PlainEngine<float>(linear, {}), InputError);
}

TEST(PlainLayout, TheCurveVisitsEachVertexOnceAndNeighboursSoon) {
  const TetMesh mesh = build_kuhn_cube(12, 0.2, 5);
  std::vector<Index> order = order_along_morton_curve(mesh.points);
  double along = 0.0;
  for (std::size_t k = 1; k < order.size(); ++k)
    along += length(mesh.points[order[k]] - mesh.points[order[k - 1]]) / static_cast<double>(order.size());
  EXPECT_LT(along, 2.5 / 12.0);  // cells; a random order makes 8
  std::sort(order.begin(), order.end());
  for (std::size_t k = 0; k < order.size(); ++k) ASSERT_EQ(order[k], k);
}

TEST(PlainLayout, EachSpringIsInOneBlockOrAcrossTwo) {
  const TetMesh mesh = build_kuhn_cube(5, 0.2, 5);
  const SpringNetwork net = make_edge_springs(mesh, 1.0);
  std::vector<Index> place(mesh.points.size());
  std::iota(place.rbegin(), place.rend(), Index{0});
  const SpringBlocks blocks = build_spring_blocks(net.springs, place, 50);
  ASSERT_EQ(blocks.inside.size(), (mesh.points.size() + 49) / 50);
  std::vector<int> seen(net.springs.size());
  for (std::size_t b = 0; b < blocks.inside.size(); ++b) {
    for (const Index s : blocks.inside[b]) {
      for (const Index end : net.springs[s]) EXPECT_EQ(place[end] / 50, b);
      seen[s] += 2;
    }
    for (const Index s : blocks.across[b]) {
      EXPECT_NE(place[net.springs[s][0]] / 50 == b, place[net.springs[s][1]] / 50 == b);
      seen[s] += 1;
    }
  }
  for (const int count : seen) EXPECT_EQ(count, 2);
}

template <typename Real>
void compare_lanes() {
  SplitMix64 random(7);
  std::array<std::array<Real, 4>, 4> in{};
  for (int round = 0; round < 100; ++round) {
    for (auto& four : in) {
      for (Real& each : four) each = static_cast<Real>(random.uniform() + 0.1);
    }
    const auto bits = [&](auto lanes) {
      using L = decltype(lanes);
      std::array<L, 4> v{L::load(in[0].data()), L::load(in[1].data()), L::load(in[2].data()),
                         L::load(in[3].data())};
      for (L& each : v) {
        std::array<Real, 4> four{};
        each.store(four.data());
        four[3] = 0;  // vectors (x, y, z, 0), as sums takes them
        each = L::load(four.data());
      }
      const L some = L::sums(v[0], v[1], v[2], v[3]) / sqrt(max(v[0], L::of(Real(0.5)))) +
                     min(v[1], v[2]) * (v[3] - v[0]);
      std::array<Real, 4> out{};
      some.store(out.data());
      return out;
    };
    ASSERT_EQ(bits(Lanes<Real>{}), bits(PortableLanes<Real>{}));
  }
}

TEST(Lanes, BothFormsGiveTheSameBits) {
  compare_lanes<float>();
  compare_lanes<double>();
}

}  // namespace
}  // namespace palpate::dynamics

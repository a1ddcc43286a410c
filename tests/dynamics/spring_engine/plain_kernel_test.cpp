#include "core/dynamics/spring_engine/plain_kernel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "core/base/large_pages.h"
#include "core/base/processor.h"
#include "core/base/random.h"
#include "core/base/types.h"
#include "core/dynamics/spring_engine/plain_engine.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/motion_cases.h"

namespace palpate::dynamics {
namespace {

using namespace testing_support;

constexpr std::size_t kFirst = 40;  // of the block
constexpr std::size_t kOwn = 60;    // vertices of the block
constexpr std::size_t kAll = 130;

/// Random particles, and random springs of the block that begins at kFirst.
template <typename Real>
struct RandomBlock {
  explicit RandomBlock(std::uint64_t seed) : random(seed), all(kAll), inside(9), across(5) {
    for (Particle<Real>& each : all) {
      for (std::size_t i = 0; i < 3; ++i) {
        each.x[i] = draw();
        each.v[i] = draw();
      }
    }
    for (InsideGroup<Real>& group : inside) {
      fill(group);
      for (std::size_t i = 0; i < kGroupSprings; ++i) {
        if (i % 4 == 0) group.hub[i / 4] = static_cast<std::uint16_t>(4 * random.below(kOwn));
        const std::size_t other = group.hub[i / 4] / 4U + 1 + random.below(kOwn - 1);
        group.b[i] = static_cast<std::uint16_t>(4 * (other % kOwn));
      }
    }
    for (AcrossGroup<Real>& group : across) {
      fill(group);
      for (std::size_t i = 0; i < kGroupSprings; ++i) {
        group.a[i] = static_cast<std::uint16_t>(4 * random.below(kOwn));
        group.b[i] = static_cast<std::uint32_t>(random.below(kFirst));
      }
    }
  }

  Real draw() { return static_cast<Real>(random.uniform()); }

  void fill(GroupConstants<Real>& group) {
    for (std::size_t i = 0; i < kGroupSprings; ++i) {
      group.stiffness[i] = draw();
      group.pull[i] = draw();
      group.damping[i] = draw();
    }
  }

  BlockSprings<Real> springs() const { return {inside, across, all.data(), kFirst}; }

  SplitMix64 random;
  LargeVector<Particle<Real>> all;
  std::vector<InsideGroup<Real>> inside;
  std::vector<AcrossGroup<Real>> across;
};

/// 4 numbers a vertex of the block.
template <typename Real>
using Force = LargeVector<Real>;

/// The formula of the header, in long double.
template <typename Real>
Force<long double> expected_force(const RandomBlock<Real>& block, Force<long double> force) {
  const auto pull = [&](const GroupConstants<Real>& group, std::size_t i, std::size_t four_a, std::size_t b,
                        bool is_inside) {
    const Particle<Real>& at_a = block.all[kFirst + four_a / 4];
    const Particle<Real>& at_b = block.all[b];
    std::array<long double, 3> d{};
    long double r_sq = 0;
    long double approach = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      d[k] = static_cast<long double>(at_b.x[k]) - at_a.x[k];
      r_sq += d[k] * d[k];
      approach += d[k] * (static_cast<long double>(at_b.v[k]) - at_a.v[k]);
    }
    const long double factor =
        group.stiffness[i] - group.pull[i] / std::sqrt(r_sq) + group.damping[i] * approach / r_sq;
    for (std::size_t k = 0; k < 3; ++k) {
      force[four_a + k] += factor * d[k];
      if (is_inside) force[4 * (b - kFirst) + k] -= factor * d[k];
    }
  };
  for (const auto& group : block.inside) {
    for (std::size_t i = 0; i < kGroupSprings; ++i)
      pull(group, i, group.hub[i / 4], kFirst + group.b[i] / 4U, true);
  }
  for (const auto& group : block.across) {
    for (std::size_t i = 0; i < kGroupSprings; ++i) pull(group, i, group.a[i], group.b[i], false);
  }
  return force;
}

template <typename Real>
void compare_with_formula(double rounding) {
  const RandomBlock<Real> block(11);
  Force<Real> force(4 * kOwn, Real(0.5));
  const Force<long double> expected = expected_force(block, Force<long double>(4 * kOwn, 0.5L));
  EXPECT_GT(add_spring_forces(block.springs(), force.data()), Real(0));
  for (std::size_t k = 0; k < 4 * kOwn; ++k) {
    // Some ten springs of size 1, a dozen roundings each; short springs enlarge them by 1 / r.
    EXPECT_NEAR(force[k], static_cast<double>(expected[k]), 1000 * rounding) << k;
  }
}

TEST(PlainKernel, IsTheFormula) {
  compare_with_formula<float>(6e-8);
  compare_with_formula<double>(1.2e-16);
}

TEST(PlainKernel, WithAvx2TheBitsAreTheSame) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const RandomBlock<float> block(seed);
    Force<float> portable(4 * kOwn, 0.5F);
    const float least = add_spring_forces(block.springs(), portable.data());
    if (!has_avx2()) continue;  // then the engine takes the other one too: see below
    Force<float> fast(4 * kOwn, 0.5F);
    EXPECT_EQ(add_spring_forces_avx2(block.springs(), fast.data()), least) << "seed " << seed;
    EXPECT_EQ(fast, portable) << "seed " << seed;
  }
}

TEST(PlainKernel, AShortestSpringOfNoLengthIsReturned) {
  RandomBlock<float> block(3);
  block.inside[2].b[5] = block.inside[2].hub[1];
  Force<float> force(4 * kOwn);
  EXPECT_EQ(add_spring_forces(block.springs(), force.data()), 0.0F);
  if (has_avx2()) {
    EXPECT_EQ(add_spring_forces_avx2(block.springs(), force.data()), 0.0F);
  }
  for (const float each : force) EXPECT_TRUE(std::isfinite(each));
}

struct Flying {
  MotionModel model;
  MotionState start;
};

/// A damped cube of 2744 vertices, two blocks, thrown at random.
Flying make_flying() {
  const TetMesh mesh = build_kuhn_cube(13, 0.2, 5);
  Flying out{make_free_body(mesh, 1e-3), {}};
  out.model.environment_damping_n_s_per_m.assign(mesh.points.size(), 0.1 * out.model.mass_kg[0]);
  out.start = start_at_rest(out.model);
  out.start.velocity_m_s = make_random_field(mesh.points.size(), 0.1, 3);
  return out;
}

TEST(PlainEngine, WithoutAvx2TheHashIsTheSame) {
  const Flying body = make_flying();
  PlainOptions portable;
  portable.portable = true;
  PlainEngine<float> fast(body.model, {});
  PlainEngine<float> slow(body.model, portable);
  EXPECT_EQ(fast.uses_avx2(), has_avx2());
  EXPECT_FALSE(slow.uses_avx2());
  EXPECT_FALSE(PlainEngine<double>(body.model, {}).uses_avx2());
  for (PlainEngine<float>* each : {&fast, &slow}) {
    each->set_state(body.start);
    each->step(1e-3, 50);
  }
  EXPECT_EQ(hash_state(fast.state()), hash_state(slow.state()));
}

/// The same body with vertices and springs numbered anew, at random.
Flying renumber(const Flying& body, std::vector<Index>& new_number, std::uint64_t seed) {
  const std::size_t n = body.model.mass_kg.size();
  SplitMix64 random(seed);
  new_number.resize(n);
  for (std::size_t v = 0; v < n; ++v) new_number[v] = static_cast<Index>(v);
  for (std::size_t v = n; v > 1; --v) std::swap(new_number[v - 1], new_number[random.below(v)]);
  Flying out = body;
  for (std::size_t v = 0; v < n; ++v) {
    const Index to = new_number[v];
    out.model.elastic.rest[to] = body.model.elastic.rest[v];
    out.model.mass_kg[to] = body.model.mass_kg[v];
    out.model.environment_damping_n_s_per_m[to] = body.model.environment_damping_n_s_per_m[v];
    out.start.velocity_m_s[to] = body.start.velocity_m_s[v];
  }
  SpringNetwork& net = out.model.elastic.springs;
  for (Edge& ends : net.springs) ends = {new_number[ends[1]], new_number[ends[0]]};
  for (std::size_t s = net.springs.size(); s > 1; --s) {
    const std::size_t other = random.below(s);
    std::swap(net.springs[s - 1], net.springs[other]);
    std::swap(net.stiffness_n_per_m[s - 1], net.stiffness_n_per_m[other]);
    std::swap(net.rest_length_m[s - 1], net.rest_length_m[other]);
    std::swap(out.model.spring_damping_n_s_per_m[s - 1], out.model.spring_damping_n_s_per_m[other]);
  }
  return out;
}

template <typename Real>
void compare_renumbered(double tolerance) {
  const Flying body = make_flying();
  std::vector<Index> new_number;
  const Flying other = renumber(body, new_number, 17);
  PlainEngine<Real> here(body.model, {});
  PlainEngine<Real> there(other.model, {});
  here.set_state(body.start);
  there.set_state(other.start);
  here.step(1e-3, 100);
  there.step(1e-3, 100);
  const MotionState at = here.state();
  const MotionState found = there.state();
  MotionState back = at;
  for (std::size_t v = 0; v < new_number.size(); ++v) {
    back.displacement_m[v] = found.displacement_m[new_number[v]];
    back.velocity_m_s[v] = found.velocity_m_s[new_number[v]];
  }
  EXPECT_LT(field_distance(back.displacement_m, at.displacement_m),
            tolerance * field_norm(at.displacement_m));
  EXPECT_LT(field_distance(back.velocity_m_s, at.velocity_m_s), tolerance * field_norm(at.velocity_m_s));
}

TEST(PlainLayout, HoweverABodyIsNumberedItsMotionChangesByRoundingAlone) {
  compare_renumbered<double>(1e-12);
  compare_renumbered<float>(1e-3);  // roundings of positions of size 1 against displacements of hundredths
}

}  // namespace
}  // namespace palpate::dynamics

#include "core/dynamics/plain_kernel.h"

#include <algorithm>

#include "core/dynamics/lanes.h"

namespace palpate::dynamics {
namespace {

/// Four springs: where their ends are and what they are made of.
template <typename Real>
struct Quad {
  std::array<const Particle<Real>*, 4> a;
  std::array<const Particle<Real>*, 4> b;
  const Real* stiffness;
  const Real* pull;
  const Real* damping;
};

/// The forces of four springs on their first ends, and the least squared length so far.
template <typename Real>
inline void pull_quad(const Quad<Real>& quad, std::array<Lanes<Real>, 4>& force, Lanes<Real>& least_sq) {
  using L = Lanes<Real>;
  std::array<L, 4> d;
  std::array<L, 4> w;
  for (std::size_t i = 0; i < 4; ++i) {
    d[i] = L::load(quad.b[i]->x.data()) - L::load(quad.a[i]->x.data());
    w[i] = L::load(quad.b[i]->v.data()) - L::load(quad.a[i]->v.data());
  }
  const L length_sq = L::sums(d[0] * d[0], d[1] * d[1], d[2] * d[2], d[3] * d[3]);
  const L approach = L::sums(d[0] * w[0], d[1] * w[1], d[2] * w[2], d[3] * w[3]);
  least_sq = min(least_sq, length_sq);
  const L safe_sq = max(length_sq, L::of(Real(1e-36)));
  const L inverse_sq = L::of(1) / safe_sq;
  const L inverse = sqrt(safe_sq) * inverse_sq;
  const L factor = (L::load(quad.stiffness) - L::load(quad.pull) * inverse) +
                   (L::load(quad.damping) * approach) * inverse_sq;
  std::array<Real, 4> factors;
  factor.store(factors.data());
  for (std::size_t i = 0; i < 4; ++i) force[i] = L::of(factors[i]) * d[i];
}

/// `second` maps what a group holds of a second end to its particle.
template <typename Real, typename End, typename Second>
inline void pull_half(const SpringGroup<Real, End>& group, std::size_t half, const Particle<Real>* own,
                      const Second& second, std::array<Lanes<Real>, 4>& force, Lanes<Real>& least_sq) {
  Quad<Real> quad{{}, {}, &group.stiffness[half], &group.pull[half], &group.damping[half]};
  for (std::size_t i = 0; i < 4; ++i) {
    quad.a[i] = own + group.a[half + i] / 4;
    quad.b[i] = second(group.b[half + i]);
  }
  pull_quad(quad, force, least_sq);
}

template <typename Group>
inline void fetch_lines_ahead(const Group& group) {
  const auto* bytes = reinterpret_cast<const char*>(&group + kGroupsAhead);
  for (std::size_t at = 0; at < sizeof(Group); at += 64) fetch_ahead(bytes + at);
}

}  // namespace

template <typename Real>
Real add_spring_forces(const BlockSprings<Real>& springs, Real* force) {
  using L = Lanes<Real>;
  const Particle<Real>* own = springs.all + springs.first;
  L least_sq = L::of(1);
  std::array<L, 4> pull;
  for (const InsideGroup<Real>& group : springs.inside) {
    fetch_lines_ahead(group);
    for (const std::size_t half : {0, 4}) {
      pull_half(
          group, half, own, [&](std::uint16_t b) { return own + b / 4; }, pull, least_sq);
      for (std::size_t i = 0; i < 4; ++i) {
        Real* on_a = force + group.a[half + i];
        Real* on_b = force + group.b[half + i];
        (L::load(on_a) + pull[i]).store(on_a);
        (L::load(on_b) - pull[i]).store(on_b);
      }
    }
  }
  for (const AcrossGroup<Real>& group : springs.across) {
    for (const std::size_t half : {0, 4}) {
      pull_half(
          group, half, own, [&](std::uint32_t b) { return springs.all + b; }, pull, least_sq);
      for (std::size_t i = 0; i < 4; ++i) {
        Real* on_a = force + group.a[half + i];
        (L::load(on_a) + pull[i]).store(on_a);
      }
    }
  }
  std::array<Real, 4> least;
  least_sq.store(least.data());
  return *std::min_element(least.begin(), least.end());
}

template float add_spring_forces(const BlockSprings<float>&, float*);
template double add_spring_forces(const BlockSprings<double>&, double*);

}  // namespace palpate::dynamics

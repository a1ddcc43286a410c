#include "core/dynamics/spring_engine/plain_kernel.h"

#include <algorithm>

#include "core/base/lanes.h"

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

template <typename Real>
inline Quad<Real> constants_of(const GroupConstants<Real>& group, std::size_t half) {
  return {{}, {}, &group.stiffness[half], &group.pull[half], &group.damping[half]};
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
      Quad<Real> quad = constants_of(group, half);
      quad.a.fill(own + group.hub[half / 4] / 4);
      for (std::size_t i = 0; i < 4; ++i) quad.b[i] = own + group.b[half + i] / 4;
      pull_quad(quad, pull, least_sq);
      for (std::size_t i = 0; i < 4; ++i) {
        Real* on_b = force + group.b[half + i];
        (L::load(on_b) - pull[i]).store(on_b);
      }
      Real* on_hub = force + group.hub[half / 4];
      (L::load(on_hub) + ((pull[0] + pull[1]) + (pull[2] + pull[3]))).store(on_hub);
    }
  }
  for (const AcrossGroup<Real>& group : springs.across) {
    for (const std::size_t half : {0, 4}) {
      Quad<Real> quad = constants_of(group, half);
      for (std::size_t i = 0; i < 4; ++i) {
        quad.a[i] = own + group.a[half + i] / 4;
        quad.b[i] = springs.all + group.b[half + i];
      }
      pull_quad(quad, pull, least_sq);
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

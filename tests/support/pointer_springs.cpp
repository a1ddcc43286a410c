#include "tests/support/pointer_springs.h"

#include <cmath>
#include <numeric>

#include "core/base/random.h"
#include "core/mesh/geometry.h"

namespace palpate::testing_support {
namespace {

template <typename Real>
PointerVector<Real> narrow(const Vec3& v) {
  return {static_cast<Real>(v.x), static_cast<Real>(v.y), static_cast<Real>(v.z)};
}

/// Makes `count` objects, one at a time, in the order asked for.
template <typename Object>
std::vector<std::unique_ptr<Object>> make_objects(std::size_t count, ObjectOrder order, SplitMix64& random) {
  std::vector<std::size_t> turn(count);
  std::iota(turn.begin(), turn.end(), std::size_t{0});
  if (order == ObjectOrder::kShuffled) {
    for (std::size_t k = count; k > 1; --k) std::swap(turn[k - 1], turn[random.below(k)]);
  }
  std::vector<std::unique_ptr<Object>> objects(count);
  for (const std::size_t k : turn) objects[k] = std::make_unique<Object>();
  return objects;
}

}  // namespace

template <typename Real>
PointerBody<Real>::PointerBody(const dynamics::MotionModel& model, ObjectOrder order, std::uint64_t seed)
    : rest_(model.elastic.rest) {
  SplitMix64 random(seed);
  vertices_ = make_objects<PointerVertex<Real>>(rest_.size(), order, random);
  const SpringNetwork& net = model.elastic.springs;
  springs_ = make_objects<PointerSpring<Real>>(net.springs.size(), order, random);
  for (std::size_t v = 0; v < rest_.size(); ++v) {
    vertices_[v]->mass = static_cast<Real>(model.mass_kg[v]);
    if (!model.environment_damping_n_s_per_m.empty())
      vertices_[v]->drag = static_cast<Real>(model.environment_damping_n_s_per_m[v]);
  }
  for (std::size_t s = 0; s < springs_.size(); ++s) {
    PointerSpring<Real>& spring = *springs_[s];
    spring.number = static_cast<int>(s);
    spring.first = vertices_[net.springs[s][0]].get();
    spring.second = vertices_[net.springs[s][1]].get();
    spring.stiffness = static_cast<Real>(net.stiffness_n_per_m[s]);
    spring.rest_length = static_cast<Real>(net.rest_length_m[s]);
    if (!model.spring_damping_n_s_per_m.empty())
      spring.damping = static_cast<Real>(model.spring_damping_n_s_per_m[s]);
    const Vec3 along = rest_[net.springs[s][1]] - rest_[net.springs[s][0]];
    spring.alpha = static_cast<Real>(std::atan2(along.y, along.x));
    spring.beta = static_cast<Real>(std::atan2(along.z, std::hypot(along.x, along.y)));
    for (PointerVertex<Real>* const end : {spring.first, spring.second}) {
      end->neighbours.push_back(end == spring.first ? spring.second : spring.first);
      end->spring_lengths.push_back(spring.rest_length);
      end->spring_numbers.push_back(spring.number);
    }
  }
  set_state(start_at_rest(model));
}

template <typename Real>
void PointerBody<Real>::set_state(const dynamics::MotionState& state) {
  time_s_ = state.time_s;
  for (std::size_t v = 0; v < rest_.size(); ++v) {
    vertices_[v]->position = narrow<Real>(rest_[v] + state.displacement_m[v]);
    vertices_[v]->velocity = narrow<Real>(state.velocity_m_s[v]);
  }
}

template <typename Real>
dynamics::MotionState PointerBody<Real>::state() const {
  dynamics::MotionState out{time_s_, std::vector<Vec3>(rest_.size()), std::vector<Vec3>(rest_.size())};
  for (std::size_t v = 0; v < rest_.size(); ++v) {
    const PointerVertex<Real>& at = *vertices_[v];
    out.displacement_m[v] = Vec3{at.position.x, at.position.y, at.position.z} - rest_[v];
    out.velocity_m_s[v] = {at.velocity.x, at.velocity.y, at.velocity.z};
  }
  return out;
}

template <typename Real>
void PointerBody<Real>::add_spring_forces() {
  for (const auto& each : springs_) {
    const PointerSpring<Real>& spring = *each;
    PointerVertex<Real>& a = *spring.first;
    PointerVertex<Real>& b = *spring.second;
    const PointerVector<Real> d{b.position.x - a.position.x, b.position.y - a.position.y,
                                b.position.z - a.position.z};
    const PointerVector<Real> w{b.velocity.x - a.velocity.x, b.velocity.y - a.velocity.y,
                                b.velocity.z - a.velocity.z};
    const Real r = std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
    if (r == 0) continue;
    const PointerVector<Real> n{d.x / r, d.y / r, d.z / r};
    const Real size =
        spring.stiffness * (r - spring.rest_length) + spring.damping * (w.x * n.x + w.y * n.y + w.z * n.z);
    const PointerVector<Real> f{size * n.x, size * n.y, size * n.z};
    a.force = {a.force.x + f.x, a.force.y + f.y, a.force.z + f.z};
    b.force = {b.force.x - f.x, b.force.y - f.y, b.force.z - f.z};
  }
}

template <typename Real>
void PointerBody<Real>::update(Real h) {
  for (const auto& each : vertices_) {
    PointerVertex<Real>& at = *each;
    PointerVector<Real>& v = at.velocity;
    const Real share = h / at.mass;
    v = {v.x + share * (at.force.x - at.drag * v.x), v.y + share * (at.force.y - at.drag * v.y),
         v.z + share * (at.force.z - at.drag * v.z)};
    at.position = {at.position.x + h * v.x, at.position.y + h * v.y, at.position.z + h * v.z};
    at.force = {};
  }
}

template <typename Real>
void PointerBody<Real>::step(double step_s, std::uint64_t steps) {
  for (std::uint64_t k = 0; k < steps; ++k) {
    add_spring_forces();
    update(static_cast<Real>(step_s));
    time_s_ += step_s;
  }
}

template class PointerBody<float>;
template class PointerBody<double>;

}  // namespace palpate::testing_support

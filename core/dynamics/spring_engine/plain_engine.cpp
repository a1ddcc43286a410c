#include "core/dynamics/spring_engine/plain_engine.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <type_traits>

#include "core/base/error.h"
#include "core/base/lanes.h"
#include "core/base/large_pages.h"
#include "core/base/processor.h"
#include "core/dynamics/spring_engine/block_team.h"
#include "core/dynamics/spring_engine/plain_kernel.h"
#include "core/dynamics/spring_engine/plain_layout.h"
#include "core/dynamics/spring_engine/plain_loads.h"
#include "core/mesh/geometry.h"
#include "core/mesh/space_order.h"

namespace palpate::dynamics {
namespace {

constexpr std::size_t kBlockVertices = 2048;
static_assert(kBlockVertices <= kMostBlockVertices);

void check_plain(const MotionModel& model) {
  validate(model);
  const std::string what = find_more_than_plain(model);
  if (!what.empty()) throw InputError("plain engine", 0, "springs with axial damping alone", what);
}

}  // namespace

std::string find_more_than_plain(const MotionModel& model) {
  if (!model.elastic.strain_terms.empty()) return "strain energies";
  if (model.elastic.volume_force) return "a volume force";
  if (model.elastic.springs_are_linear) return "linearised springs";
  const bool is_isotropic = model.spring_damping == SpringDamping::kIsotropic;
  return is_isotropic && !model.spring_damping_n_s_per_m.empty() ? "isotropic damping" : "";
}

template <typename Real>
struct PlainEngine<Real>::Body {
  /// Where a block's groups begin; the next one's begin where they end.
  struct Block {
    std::size_t inside = 0;
    std::size_t across = 0;
  };
  static constexpr std::size_t kStride = sizeof(Particle<Real>) / sizeof(Real);

  Body(const MotionModel& model, const PlainOptions& given) : options(given), rest(model.elastic.rest) {
    check_plain(model);
    use_avx2 = std::is_same_v<Real, float> && !given.portable && has_avx2();
    const BoundingBox box = bounding_box(rest);
    center = 0.5 * (box.low + box.high);
    order = order_in_space(rest);
    place.resize(order.size());
    for (std::size_t k = 0; k < order.size(); ++k) place[order[k]] = static_cast<Index>(k);
    const SpringBlocks layout = build_spring_blocks(model.elastic.springs.springs, place, kBlockVertices);
    for (std::size_t b = 0; b < layout.inside.size(); ++b) {
      blocks.push_back({inside.size(), across.size()});
      pack_inside(model, layout.inside[b], b);
      pack_across(model, layout.across[b], b);
      across_count += layout.across[b].size();
    }
    blocks.push_back({inside.size(), across.size()});
    across_count /= 2;
    spring_count = model.elastic.springs.springs.size();
    now.resize(order.size());
    next.resize(order.size());
    watched.resize(block_count());
    loads.emplace(model, PlainPlaces{order, place, kBlockVertices, center});
    set_inertia(model);
  }

  void pack_inside(const MotionModel& model, const std::vector<SpringFan>& fans, std::size_t block) {
    const std::size_t first = block * kBlockVertices;
    for (std::size_t k = 0; k < fans.size(); ++k) {
      if (k % 2 == 0) inside.emplace_back();
      InsideGroup<Real>& group = inside.back();
      const std::size_t half = k % 2;
      const SpringFan& fan = fans[k];
      group.hub[half] = static_cast<std::uint16_t>(4 * (place[fan.hub] - first));
      for (std::size_t i = 0; i < 4; ++i) {
        // What is missing repeats a spring of the fan, and a fan the one before, without force.
        const bool is_there = fan.springs[i] != kNoIndex;
        const Index s = fan.springs[is_there ? i : 0];
        const Edge& ends = model.elastic.springs.springs[s];
        const Index other = ends[0] == fan.hub ? ends[1] : ends[0];
        group.b[4 * half + i] = static_cast<std::uint16_t>(4 * (place[other] - first));
        if (is_there) set_constants(model, s, group, 4 * half + i);
      }
      if (k + 1 < fans.size() || half == 1) continue;
      group.hub[1] = group.hub[0];
      std::copy_n(group.b.begin(), 4, group.b.begin() + 4);
    }
  }

  void pack_across(const MotionModel& model, const std::vector<Index>& list, std::size_t block) {
    const std::size_t before = across.size();
    across.resize(before + (list.size() + kGroupSprings - 1) / kGroupSprings);
    for (std::size_t k = 0; k < kGroupSprings * (across.size() - before); ++k) {
      AcrossGroup<Real>& group = across[before + k / kGroupSprings];
      const std::size_t lane = k % kGroupSprings;
      const Index s = list[std::min(k, list.size() - 1)];
      const Edge& ends = model.elastic.springs.springs[s];
      std::size_t a = place[ends[0]];
      std::size_t b = place[ends[1]];
      if (a / kBlockVertices != block) std::swap(a, b);
      group.a[lane] = static_cast<std::uint16_t>(4 * (a - block * kBlockVertices));
      group.b[lane] = static_cast<std::uint32_t>(b);
      if (k < list.size()) set_constants(model, s, group, lane);  // else the last spring again, without force
    }
  }

  static void set_constants(const MotionModel& model, Index s, GroupConstants<Real>& group,
                            std::size_t lane) {
    const SpringNetwork& net = model.elastic.springs;
    group.stiffness[lane] = static_cast<Real>(net.stiffness_n_per_m[s]);
    group.pull[lane] = static_cast<Real>(net.stiffness_n_per_m[s] * net.rest_length_m[s]);
    group.damping[lane] = model.spring_damping_n_s_per_m.empty()
                              ? Real(0)
                              : static_cast<Real>(model.spring_damping_n_s_per_m[s]);
  }

  void set_inertia(const MotionModel& model) {
    inertia.resize(order.size());
    for (std::size_t k = 0; k < order.size(); ++k) {
      const Index v = order[k];
      const Vec3& load = loads->steady_force(k);
      if (length_sq(load) > 0.0) steady.resize(order.size());
      if (!steady.empty())
        steady[k] = {static_cast<Real>(load.x), static_cast<Real>(load.y), static_cast<Real>(load.z),
                     Real(0)};
      inertia[k].inverse_mass = loads->is_held(k) ? Real(0) : static_cast<Real>(1.0 / model.mass_kg[v]);
      if (!model.environment_damping_n_s_per_m.empty())
        inertia[k].drag = static_cast<Real>(model.environment_damping_n_s_per_m[v]);
    }
  }

  std::size_t block_count() const { return blocks.size() - 1; }

  /// One step of one block: from `now` to `next`.
  void step_block(std::size_t b, Real h, PlainReport& report) {
    const std::size_t first = b * kBlockVertices;
    const std::size_t count = std::min(kBlockVertices, now.size() - first);
    alignas(64) std::array<Real, 4 * kBlockVertices> force;
    if (steady.empty()) {
      std::fill_n(force.begin(), 4 * count, Real(0));
    } else {
      std::copy_n(steady[first].data(), 4 * count, force.data());
    }
    const BlockSprings<Real> springs{{inside.data() + blocks[b].inside, inside.data() + blocks[b + 1].inside},
                                     {across.data() + blocks[b].across, across.data() + blocks[b + 1].across},
                                     now.data(),
                                     first};
    for (const AcrossGroup<Real>& group : springs.across) {
      for (const std::uint32_t other : group.b) fetch_ahead(now.data() + other);
    }
    if (add_springs(springs, force.data()) < Real(1e-36)) ++report.steps_with_zero_length;
    loads->add_forces(b, PlainRows<const Real>{now[0].x.data(), kStride}, force.data());
    update(first, count, force.data(), h, report);
    loads->hold(b, PlainRows<Real>{next[0].x.data(), kStride}, PlainRows<Real>{next[0].v.data(), kStride});
    if (options.escape_m > 0.0) watch(b);
  }

  /// Velocities and positions of a block's vertices from their forces, and fetches the next block's.
  void update(std::size_t first, std::size_t count, const Real* force, Real h, PlainReport& report) {
    using L = Lanes<Real>;
    const Particle<Real>* next_block = now.data() + first + kBlockVertices;
    for (std::size_t k = 0; k < count; ++k) {
      fetch_ahead(next_block + k);
      const Particle<Real>& from = now[first + k];
      const Inertia<Real>& own = inertia[first + k];
      const L speed = L::load(from.v.data());
      L v = speed + L::of(h * own.inverse_mass) * (L::load(force + 4 * k) - L::of(own.drag) * speed);
      if (options.speed_limit_m_s > 0.0 && own.inverse_mass > 0)
        v = cut_speed<Real>(v, options.speed_limit_m_s, report);
      Particle<Real>& to = next[first + k];
      v.store(to.v.data());
      (L::load(from.x.data()) + L::of(h) * v).store(to.x.data());
    }
  }

  /// Notes the fastest and the farthest vertex of a block; a sum keeps what is not finite.
  void watch(std::size_t b) {
    const std::size_t first = b * kBlockVertices;
    const std::size_t count = std::min(kBlockVertices, next.size() - first);
    Watched<Real> seen;
    for (std::size_t k = first; k < first + count; ++k) {
      const auto& [x, v] = next[k];
      seen.note(x[0] * x[0] + x[1] * x[1] + x[2] * x[2], v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    }
    watched[b] = seen;
  }

  Real add_springs(const BlockSprings<Real>& springs, Real* force) const {
    if constexpr (std::is_same_v<Real, float>) {
      if (use_avx2) return add_spring_forces_avx2(springs, force);
    }
    return add_spring_forces(springs, force);
  }

  /// Steps with `threads` threads, each with blocks of its own.
  PlainReport run(double step_s, std::uint64_t steps, const PlainObserver& observer) {
    const auto h = static_cast<Real>(step_s);
    const TeamStep<Real> step{{[&](std::size_t b, std::size_t, PlainReport& own) { step_block(b, h, own); }},
                              [&] { now.swap(next); },
                              watched,
                              block_count()};
    return step_in_team(options, step, step_s, steps, *loads, time_s, observer);
  }

  PlainOptions options;
  std::vector<Vec3> rest;
  Vec3 center;
  std::vector<Index> order;
  std::vector<Index> place;
  std::vector<Block> blocks;  ///< and one more, where the last one ends
  LargeVector<InsideGroup<Real>> inside;
  LargeVector<AcrossGroup<Real>> across;
  LargeVector<std::array<Real, 4>> steady;  ///< loads that do not change; empty if there are none
  LargeVector<Inertia<Real>> inertia;
  LargeVector<Particle<Real>> now;
  LargeVector<Particle<Real>> next;
  std::optional<PlainLoads> loads;
  std::vector<Watched<Real>> watched;
  bool use_avx2 = false;
  double time_s = 0.0;
  std::size_t spring_count = 0;
  std::size_t across_count = 0;
};

template <typename Real>
PlainEngine<Real>::PlainEngine(const MotionModel& model, const PlainOptions& options)
    : body_(std::make_unique<Body>(model, options)) {
  set_state(start_at_rest(model));
}
template <typename Real>
PlainEngine<Real>::~PlainEngine() = default;
template <typename Real>
PlainEngine<Real>::PlainEngine(PlainEngine&&) noexcept = default;
template <typename Real>
PlainEngine<Real>& PlainEngine<Real>::operator=(PlainEngine&&) noexcept = default;

template <typename Real>
void PlainEngine<Real>::set_state(const MotionState& state) {
  const std::size_t n = body_->order.size();
  require(state.displacement_m.size() == n && state.velocity_m_s.size() == n, "one entry a vertex");
  body_->time_s = state.time_s;
  for (std::size_t k = 0; k < n; ++k) {
    const Index v = body_->order[k];
    const Vec3 x = (body_->rest[v] - body_->center) + state.displacement_m[v];
    const Vec3 speed = body_->inertia[k].inverse_mass > 0 ? state.velocity_m_s[v] : Vec3{};
    body_->now[k].x = {static_cast<Real>(x.x), static_cast<Real>(x.y), static_cast<Real>(x.z), Real(0)};
    body_->now[k].v = {static_cast<Real>(speed.x), static_cast<Real>(speed.y), static_cast<Real>(speed.z),
                       Real(0)};
  }
  Body& body = *body_;
  body.loads->hold_all(body.time_s, PlainRows<Real>{body.now[0].x.data(), Body::kStride},
                       PlainRows<Real>{body.now[0].v.data(), Body::kStride});
}

template <typename Real>
MotionState PlainEngine<Real>::state() const {
  const std::size_t n = body_->order.size();
  MotionState out{body_->time_s, std::vector<Vec3>(n), std::vector<Vec3>(n)};
  for (std::size_t k = 0; k < n; ++k) {
    const Index v = body_->order[k];
    const Particle<Real>& at = body_->now[k];
    const Vec3 x{at.x[0], at.x[1], at.x[2]};
    out.displacement_m[v] = x - (body_->rest[v] - body_->center);
    out.velocity_m_s[v] = {at.v[0], at.v[1], at.v[2]};
  }
  return out;
}

template <typename Real>
PlainReport PlainEngine<Real>::step(double step_s, std::uint64_t steps, const PlainObserver& observer) {
  require(step_s > 0.0 && std::isfinite(step_s), "a finite step above zero");
  return body_->run(step_s, steps, observer);
}

template <typename Real>
const std::vector<Vec3>& PlainEngine<Real>::group_forces() const {
  return body_->loads->group_forces();
}

template <typename Real>
void PlainEngine<Real>::set_pad(std::span<const SupportFace> faces) {
  Body& body = *body_;
  body.loads->set_pad(faces, PlainPlaces{body.order, body.place, kBlockVertices, body.center}, body.rest);
}

template <typename Real>
void PlainEngine<Real>::move_pad(const Vec3& by_m) {
  body_->loads->move_pad(by_m);
}

template <typename Real>
Vec3 PlainEngine<Real>::pad_force() const {
  return body_->loads->pad_force();
}

template <typename Real>
bool PlainEngine<Real>::uses_avx2() const {
  return body_->use_avx2;
}

template <typename Real>
std::size_t PlainEngine<Real>::bytes_per_step() const {
  const auto bytes = [](const auto& list) { return list.size() * sizeof(list[0]); };
  const Body& body = *body_;
  return bytes(body.inside) + bytes(body.across) + bytes(body.steady) + bytes(body.inertia) +
         bytes(body.now) + bytes(body.next);
}

template <typename Real>
std::size_t PlainEngine<Real>::springs() const {
  return body_->spring_count;
}

template <typename Real>
std::size_t PlainEngine<Real>::springs_across() const {
  return body_->across_count;
}

template class PlainEngine<float>;
template class PlainEngine<double>;

}  // namespace palpate::dynamics

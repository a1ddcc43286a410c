#include "core/dynamics/plain_engine.h"

#include <algorithm>
#include <array>
#include <barrier>
#include <cmath>
#include <numeric>
#include <optional>
#include <string>
#include <thread>

#include "core/base/error.h"
#include "core/dynamics/lanes.h"
#include "core/dynamics/plain_layout.h"
#include "core/dynamics/plain_loads.h"
#include "core/mesh/geometry.h"

namespace palpate::dynamics {
namespace {

constexpr std::size_t kBlockVertices = 1024;

/// Position and velocity of a vertex side by side: 32 bytes in single precision.
template <typename Real>
struct alignas(8 * sizeof(Real)) Particle {
  std::array<Real, 4> x{};  ///< the last one is zero
  std::array<Real, 4> v{};
};

/// Four springs. Ends are places in curve order; in a list of springs across blocks, b lies in another one.
template <typename Real>
struct SpringQuad {
  std::array<Index, 4> a{};
  std::array<Index, 4> b{};
  std::array<Real, 4> stiffness{};
  std::array<Real, 4> pull{};  ///< stiffness x rest length
  std::array<Real, 4> damping{};
};

/// What a vertex has of its own.
template <typename Real>
struct Inertia {
  std::array<Real, 4> load{};
  Real inverse_mass = 0;  ///< 0 where it is held
  Real drag = 0;
};

/// The forces of four springs on their first ends, and the least squared length so far.
template <typename Real>
inline void pull_quad(const SpringQuad<Real>& quad, const Particle<Real>* at,
                      std::array<Lanes<Real>, 4>& force, Lanes<Real>& least_sq) {
  using L = Lanes<Real>;
  std::array<L, 4> d;
  std::array<L, 4> w;
  for (std::size_t i = 0; i < 4; ++i) {
    const Particle<Real>& a = at[quad.a[i]];
    const Particle<Real>& b = at[quad.b[i]];
    d[i] = L::load(b.x.data()) - L::load(a.x.data());
    w[i] = L::load(b.v.data()) - L::load(a.v.data());
  }
  const L length_sq = L::sums(d[0] * d[0], d[1] * d[1], d[2] * d[2], d[3] * d[3]);
  const L approach = L::sums(d[0] * w[0], d[1] * w[1], d[2] * w[2], d[3] * w[3]);
  least_sq = min(least_sq, length_sq);
  // Below this a spring has no direction: its d is then too small to matter.
  const L inverse = L::of(1) / sqrt(max(length_sq, L::of(Real(1e-36))));
  const L factor = (L::load(quad.stiffness.data()) - L::load(quad.pull.data()) * inverse) +
                   (L::load(quad.damping.data()) * approach) * (inverse * inverse);
  std::array<Real, 4> factors;
  factor.store(factors.data());
  for (std::size_t i = 0; i < 4; ++i) force[i] = L::of(factors[i]) * d[i];
}

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
  struct Block {
    std::vector<SpringQuad<Real>> inside;
    std::vector<SpringQuad<Real>> across;
  };
  struct Watched {
    Real speed_sq = 0;
    Real farthest_sq = 0;
    Real sum = 0;
  };
  static constexpr std::size_t kStride = sizeof(Particle<Real>) / sizeof(Real);

  Body(const MotionModel& model, const PlainOptions& given) : options(given), rest(model.elastic.rest) {
    check_plain(model);
    const BoundingBox box = bounding_box(rest);
    center = 0.5 * (box.low + box.high);
    order = order_along_morton_curve(rest);
    place.resize(order.size());
    for (std::size_t k = 0; k < order.size(); ++k) place[order[k]] = static_cast<Index>(k);
    const SpringBlocks layout = build_spring_blocks(model.elastic.springs.springs, place, kBlockVertices);
    blocks.resize(layout.inside.size());
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      blocks[b].inside = pack(model, layout.inside[b], b);
      blocks[b].across = pack(model, layout.across[b], b);
      across_count += layout.across[b].size();
    }
    across_count /= 2;
    spring_count = model.elastic.springs.springs.size();
    now.resize(order.size());
    next.resize(order.size());
    watched.resize(blocks.size());
    loads.emplace(model, PlainPlaces{order, place, kBlockVertices, center});
    set_inertia(model);
  }

  std::vector<SpringQuad<Real>> pack(const MotionModel& model, const std::vector<Index>& list,
                                     std::size_t block) const {
    const SpringNetwork& net = model.elastic.springs;
    std::vector<SpringQuad<Real>> quads((list.size() + 3) / 4);
    for (std::size_t k = 0; k < 4 * quads.size(); ++k) {
      SpringQuad<Real>& quad = quads[k / 4];
      const std::size_t lane = k % 4;
      const Index s = list[std::min(k, list.size() - 1)];
      quad.a[lane] = place[net.springs[s][0]];
      quad.b[lane] = place[net.springs[s][1]];
      if (quad.a[lane] / kBlockVertices != block) std::swap(quad.a[lane], quad.b[lane]);
      if (k >= list.size()) continue;  // the last spring again, without force
      quad.stiffness[lane] = static_cast<Real>(net.stiffness_n_per_m[s]);
      quad.pull[lane] = static_cast<Real>(net.stiffness_n_per_m[s] * net.rest_length_m[s]);
      quad.damping[lane] = model.spring_damping_n_s_per_m.empty()
                               ? Real(0)
                               : static_cast<Real>(model.spring_damping_n_s_per_m[s]);
    }
    return quads;
  }

  void set_inertia(const MotionModel& model) {
    inertia.resize(order.size());
    for (std::size_t k = 0; k < order.size(); ++k) {
      const Index v = order[k];
      const Vec3& load = loads->steady_force(k);
      inertia[k].load = {static_cast<Real>(load.x), static_cast<Real>(load.y), static_cast<Real>(load.z),
                         Real(0)};
      inertia[k].inverse_mass = loads->is_held(k) ? Real(0) : static_cast<Real>(1.0 / model.mass_kg[v]);
      if (!model.environment_damping_n_s_per_m.empty())
        inertia[k].drag = static_cast<Real>(model.environment_damping_n_s_per_m[v]);
    }
  }

  /// One step of one block: from `now` to `next`.
  void step_block(std::size_t b, Real h, PlainReport& report, bool& has_zero) {
    using L = Lanes<Real>;
    const std::size_t first = b * kBlockVertices;
    const std::size_t count = std::min(kBlockVertices, now.size() - first);
    alignas(64) std::array<Real, 4 * kBlockVertices> force;
    for (std::size_t k = 0; k < count; ++k)
      std::copy(inertia[first + k].load.begin(), inertia[first + k].load.end(), &force[4 * k]);
    L least_sq = L::of(1);
    std::array<L, 4> pull;
    for (const SpringQuad<Real>& quad : blocks[b].inside) {
      pull_quad(quad, now.data(), pull, least_sq);
      for (std::size_t i = 0; i < 4; ++i) {
        Real* on_a = &force[4 * (quad.a[i] - first)];
        Real* on_b = &force[4 * (quad.b[i] - first)];
        (L::load(on_a) + pull[i]).store(on_a);
        (L::load(on_b) - pull[i]).store(on_b);
      }
    }
    for (const SpringQuad<Real>& quad : blocks[b].across) {
      pull_quad(quad, now.data(), pull, least_sq);
      for (std::size_t i = 0; i < 4; ++i) {
        Real* on_a = &force[4 * (quad.a[i] - first)];
        (L::load(on_a) + pull[i]).store(on_a);
      }
    }
    std::array<Real, 4> least;
    least_sq.store(least.data());
    has_zero = has_zero || *std::min_element(least.begin(), least.end()) < Real(1e-36);
    loads->add_forces(b, PlainRows<const Real>{now[0].x.data(), kStride}, force.data());
    for (std::size_t k = 0; k < count; ++k) {
      const Particle<Real>& from = now[first + k];
      const Inertia<Real>& own = inertia[first + k];
      const L speed = L::load(from.v.data());
      L v = speed + L::of(h * own.inverse_mass) * (L::load(&force[4 * k]) - L::of(own.drag) * speed);
      if (options.speed_limit_m_s > 0.0 && own.inverse_mass > 0) v = cut(v, report);
      Particle<Real>& to = next[first + k];
      v.store(to.v.data());
      (L::load(from.x.data()) + L::of(h) * v).store(to.x.data());
    }
    loads->hold(b, PlainRows<Real>{next[0].x.data(), kStride}, PlainRows<Real>{next[0].v.data(), kStride});
    if (options.escape_m > 0.0) watch(b);
  }

  /// Notes the fastest and the farthest vertex of a block; a sum keeps what is not finite.
  void watch(std::size_t b) {
    const std::size_t first = b * kBlockVertices;
    const std::size_t count = std::min(kBlockVertices, next.size() - first);
    Watched seen;
    for (std::size_t k = first; k < first + count; ++k) {
      const auto& [x, v] = next[k];
      const Real away_sq = x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
      const Real speed_sq = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
      seen.farthest_sq = std::max(seen.farthest_sq, away_sq);
      seen.speed_sq = std::max(seen.speed_sq, speed_sq);
      seen.sum += away_sq + speed_sq;
    }
    watched[b] = seen;
  }

  /// Whether the last step left a state that is finite and within bounds.
  bool is_good(PlainReport& report) const {
    const auto escape = static_cast<Real>(options.escape_m);
    bool good = true;
    Real speed_sq = 0;
    for (const Watched& seen : watched) {
      good = good && std::isfinite(seen.sum) && seen.farthest_sq <= escape * escape;
      speed_sq = std::max(speed_sq, seen.speed_sq);
    }
    if (good)
      report.peak_speed_m_s = std::max(report.peak_speed_m_s, std::sqrt(static_cast<double>(speed_sq)));
    return good;
  }

  Lanes<Real> cut(const Lanes<Real>& v, PlainReport& report) const {
    std::array<Real, 4> each;
    v.store(each.data());
    const auto limit = static_cast<Real>(options.speed_limit_m_s);
    const Real speed_sq = each[0] * each[0] + each[1] * each[1] + each[2] * each[2];
    if (!(speed_sq > limit * limit)) return v;
    ++report.speeds_cut;
    return Lanes<Real>::of(limit / std::sqrt(speed_sq)) * v;
  }

  /// Steps with `threads` threads, each with blocks of its own.
  PlainReport run(double step_s, std::uint64_t steps, const PlainObserver& observer) {
    const auto h = static_cast<Real>(step_s);
    const std::size_t threads = std::clamp<std::size_t>(
        static_cast<std::size_t>(std::max(options.threads, 1)), 1, std::max<std::size_t>(blocks.size(), 1));
    std::vector<char> zero(threads);
    std::vector<std::uint64_t> cuts(threads);
    std::uint64_t cuts_before = 0;
    PlainReport sum;
    bool is_over = false;
    if (steps == 0) return sum;
    loads->set_times(time_s, time_s + step_s);
    const auto end_step = [&]() noexcept {
      now.swap(next);
      ++sum.steps;
      time_s += step_s;
      loads->gather();
      loads->set_times(time_s, time_s + step_s);
      sum.diverged = options.escape_m > 0.0 && !is_good(sum);
      is_over = sum.diverged || sum.steps == steps;
      bool has_zero = false;
      for (char& each : zero) {
        has_zero = has_zero || each != 0;
        each = 0;
      }
      sum.steps_with_zero_length += has_zero ? 1 : 0;
      sum.speeds_cut = std::accumulate(cuts.begin(), cuts.end(), std::uint64_t{0});
      sum.steps_with_cuts += sum.speeds_cut > cuts_before ? 1 : 0;
      cuts_before = sum.speeds_cut;
      if (observer) observer(sum.steps);
    };
    std::barrier team(static_cast<std::ptrdiff_t>(threads), end_step);
    const auto work = [&](std::size_t t) {
      PlainReport report;
      for (;;) {
        bool has_zero = false;
        for (std::size_t b = blocks.size() * t / threads; b < blocks.size() * (t + 1) / threads; ++b)
          step_block(b, h, report, has_zero);
        zero[t] = has_zero ? 1 : 0;
        cuts[t] = report.speeds_cut;
        team.arrive_and_wait();
        if (is_over) return;
      }
    };
    {
      std::vector<std::jthread> others;
      for (std::size_t t = 1; t < threads; ++t) others.emplace_back(work, t);
      work(0);
    }
    return sum;
  }

  PlainOptions options;
  std::vector<Vec3> rest;
  Vec3 center;
  std::vector<Index> order;
  std::vector<Index> place;
  std::vector<Block> blocks;
  std::vector<Inertia<Real>> inertia;
  std::vector<Particle<Real>> now;
  std::vector<Particle<Real>> next;
  std::optional<PlainLoads> loads;
  std::vector<Watched> watched;
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

#include "core/dynamics/tet_engine/tet_engine.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/base/error.h"
#include "core/base/lanes.h"
#include "core/base/large_pages.h"
#include "core/base/processor.h"
#include "core/dynamics/spring_engine/block_team.h"
#include "core/dynamics/spring_engine/plain_kernel.h"
#include "core/dynamics/spring_engine/plain_loads.h"
#include "core/dynamics/tet_engine/domain_kernel.h"
#include "core/dynamics/tet_engine/domain_packing.h"
#include "core/mesh/geometry.h"
#include "core/mesh/space_order.h"

namespace palpate::dynamics {
namespace {

constexpr std::size_t kBlockVertices = 2048;

/// Bodies are cut into blocks of equal size, so that two threads have the same to do.
std::size_t choose_block_vertices(std::size_t vertices) {
  const std::size_t blocks = std::max<std::size_t>(1, (vertices + kBlockVertices - 1) / kBlockVertices);
  return std::max<std::size_t>(1, (vertices + blocks - 1) / blocks);
}

}  // namespace

std::string find_more_than_tets(const MotionModel& model) {
  if (!model.elastic.springs.springs.empty()) return "springs";
  if (model.elastic.volume_force) return "a volume force";
  if (model.elastic.strain_terms.empty()) return "no strain energy";
  for (const StrainTerm& term : model.elastic.strain_terms) {
    for (std::size_t s = 0; s < term.op.domains(); ++s) {
      if (term.op.vertices_of(s).size() > kBlockVertices) return "a domain of too many vertices";
    }
  }
  return "";
}

template <typename Real>
struct TetEngine<Real>::Body {
  using Row = std::array<Real, 4>;

  /// What a block sees, copied together; one a thread.
  struct Scratch {
    LargeVector<Row> u;
    LargeVector<Row> v;
    LargeVector<Row> damped;  ///< u + damping v
  };

  Body(const MotionModel& model, const PlainOptions& given) : options(given), rest(model.elastic.rest) {
    validate(model);
    const std::string what = find_more_than_tets(model);
    if (!what.empty()) throw InputError("tet engine", 0, "strain energies alone", what);
    use_avx2 = !given.portable && has_avx2();
    order = order_in_space(model.elastic.rest);
    place.resize(order.size());
    for (std::size_t k = 0; k < order.size(); ++k) place[order[k]] = static_cast<Index>(k);
    block_vertices = choose_block_vertices(order.size());
    for (const StrainTerm& term : model.elastic.strain_terms) {
      laws.push_back({term.law, term.moduli, model.strain_damping_s});
      is_linear = is_linear || term.law == StrainLaw::kLinear;
      is_turning = is_turning || term.law != StrainLaw::kLinear;
      domain_count += term.op.domains();
    }
    damping_s = model.strain_damping_s;
    packed = pack_domains<Real>(model.elastic.strain_terms, place, block_vertices);
    sums.resize(packed.rows);
    u_now.resize(order.size());
    u_next.resize(order.size());
    v.resize(order.size());
    watched.resize(packed.blocks.size());
    const BoundingBox box = bounding_box(model.elastic.rest);
    const Vec3 center = 0.5 * (box.low + box.high);
    for (std::size_t k = 0; options.escape_m > 0.0 && k < order.size(); ++k)
      home.push_back(row_of(model.elastic.rest[order[k]] - center));
    loads.emplace(model, PlainPlaces{order, place, block_vertices, center, true});
    set_inertia(model);
  }

  static Row row_of(const Vec3& a) {
    return {static_cast<Real>(a.x), static_cast<Real>(a.y), static_cast<Real>(a.z), Real(0)};
  }

  void set_inertia(const MotionModel& model) {
    inertia.resize(order.size());
    for (std::size_t k = 0; k < order.size(); ++k) {
      const Index vertex = order[k];
      const Vec3& load = loads->steady_force(k);
      if (length_sq(load) > 0.0) steady.resize(order.size());
      if (!steady.empty()) steady[k] = row_of(load);
      inertia[k].inverse_mass = loads->is_held(k) ? Real(0) : static_cast<Real>(1.0 / model.mass_kg[vertex]);
      if (!model.environment_damping_n_s_per_m.empty())
        inertia[k].drag = static_cast<Real>(model.environment_damping_n_s_per_m[vertex]);
    }
  }

  /// Displacements and velocities that a block sees, in the order of its rows.
  void collect(const PackedBlock& block, Scratch& seen) const {
    using L = Lanes<Real>;
    const std::size_t rows = block.rows();
    const L b = L::of(static_cast<Real>(damping_s));
    const bool is_damped = damping_s != 0.0;
    for (LargeVector<Row>* each : {&seen.u, &seen.v, &seen.damped}) {
      if (each->size() < rows) each->resize(rows);
    }
    for (std::size_t k = 0; k < rows; ++k) {
      const std::size_t from = k < block.count ? block.first + k : block.halo[k - block.count];
      const L u = L::load(u_now[from].data());
      u.store(seen.u[k].data());
      if (!is_damped) continue;
      const L speed = L::load(v[from].data());
      if (is_turning) speed.store(seen.v[k].data());
      if (is_linear) (u + b * speed).store(seen.damped[k].data());
    }
  }

  /// Forces of a block's domains on what it sees.
  void pull_block(std::size_t b, Scratch& seen) {
    const PackedBlock& block = packed.blocks[b];
    collect(block, seen);
    Real* const force = sums[block.first_row].data();
    std::fill_n(force, 4 * block.rows(), Real(0));
    if (!steady.empty()) std::copy_n(steady[block.first].data(), 4 * block.count, force);
    for (const PackedRun& run : block.runs) {
      const DomainLaw& law = laws[run.term];
      const bool takes_damped = law.law == StrainLaw::kLinear && damping_s != 0.0;
      const BlockMotion<Real> motion{(takes_damped ? seen.damped : seen.u)[0].data(), seen.v[0].data()};
      const DomainRun<Real> domains{run.vertices, run.groups, packed.values.data() + run.values,
                                    packed.at.data() + run.at};
      if (use_avx2) {
        add_domain_forces_avx2(law, domains, motion, force);
      } else {
        add_domain_forces(law, domains, motion, force);
      }
    }
  }

  /// Moves a block's vertices once all blocks have pulled.
  void move_block(std::size_t b, Real h, PlainReport& report) {
    using L = Lanes<Real>;
    const PackedBlock& block = packed.blocks[b];
    Row* const force = &sums[block.first_row];
    for (const IncomingRow& each : block.incoming) {
      Real* const to = force[each.to].data();
      (L::load(to) + L::load(sums[each.from].data())).store(to);
    }
    loads->add_forces(b, PlainRows<const Real>{u_now[0].data(), 4}, force->data());
    for (std::size_t k = 0; k < block.count; ++k) {
      const Inertia<Real>& own = inertia[block.first + k];
      Row& at_v = v[block.first + k];
      const L speed = L::load(at_v.data());
      L next = speed + L::of(h * own.inverse_mass) * (L::load(force[k].data()) - L::of(own.drag) * speed);
      if (options.speed_limit_m_s > 0.0 && own.inverse_mass > 0)
        next = cut_speed<Real>(next, options.speed_limit_m_s, report);
      next.store(at_v.data());
      (L::load(u_now[block.first + k].data()) + L::of(h) * next).store(u_next[block.first + k].data());
    }
    loads->hold(b, PlainRows<Real>{u_next[0].data(), 4}, PlainRows<Real>{v[0].data(), 4});
    if (options.escape_m > 0.0) watch(b);
  }

  /// Notes the fastest and the farthest vertex of a block; a sum keeps what is not finite.
  void watch(std::size_t b) {
    Watched<Real> seen;
    const PackedBlock& block = packed.blocks[b];
    for (std::size_t k = block.first; k < block.first + block.count; ++k) {
      Real away_sq = 0;
      Real speed_sq = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        const Real x = home[k][i] + u_next[k][i];
        away_sq += x * x;
        speed_sq += v[k][i] * v[k][i];
      }
      seen.note(away_sq, speed_sq);
    }
    watched[b] = seen;
  }

  /// Steps with `threads` threads, each with blocks of its own. All pull, then all move.
  PlainReport run(double step_s, std::uint64_t steps, const PlainObserver& observer) {
    const auto h = static_cast<Real>(step_s);
    const std::size_t blocks = packed.blocks.size();
    scratch.resize(std::max(scratch.size(), team_size(options, blocks)));
    const TeamStep<Real> step{
        {[&](std::size_t b, std::size_t thread, PlainReport&) { pull_block(b, scratch[thread]); },
         [&](std::size_t b, std::size_t, PlainReport& own) { move_block(b, h, own); }},
        [&] { u_now.swap(u_next); },
        watched,
        blocks};
    return step_in_team(options, step, step_s, steps, *loads, time_s, observer);
  }

  PlainOptions options;
  std::vector<Vec3> rest;
  std::vector<Index> order;
  std::vector<Index> place;
  std::size_t block_vertices = 0;
  std::vector<DomainLaw> laws;  ///< of the terms
  double damping_s = 0.0;
  bool is_linear = false;   ///< some term
  bool is_turning = false;  ///< some term
  PackedDomains<Real> packed;
  LargeVector<Row> sums;    ///< forces, one for each of its rows
  LargeVector<Row> steady;  ///< loads that do not change; empty if there are none
  LargeVector<Row> home;    ///< the rest shape, from its centre; empty if nothing is watched
  LargeVector<Inertia<Real>> inertia;
  LargeVector<Row> u_now;
  LargeVector<Row> u_next;
  LargeVector<Row> v;
  std::vector<Scratch> scratch;  ///< one a thread
  std::optional<PlainLoads> loads;
  std::vector<Watched<Real>> watched;
  bool use_avx2 = false;
  double time_s = 0.0;
  std::size_t domain_count = 0;
};

template <typename Real>
TetEngine<Real>::TetEngine(const MotionModel& model, const PlainOptions& options)
    : body_(std::make_unique<Body>(model, options)) {
  set_state(start_at_rest(model));
}
template <typename Real>
TetEngine<Real>::~TetEngine() = default;
template <typename Real>
TetEngine<Real>::TetEngine(TetEngine&&) noexcept = default;
template <typename Real>
TetEngine<Real>& TetEngine<Real>::operator=(TetEngine&&) noexcept = default;

template <typename Real>
void TetEngine<Real>::set_state(const MotionState& state) {
  Body& body = *body_;
  const std::size_t n = body.order.size();
  require(state.displacement_m.size() == n && state.velocity_m_s.size() == n, "one entry a vertex");
  body.time_s = state.time_s;
  for (std::size_t k = 0; k < n; ++k) {
    const Index vertex = body.order[k];
    body.u_now[k] = Body::row_of(state.displacement_m[vertex]);
    body.v[k] = Body::row_of(body.inertia[k].inverse_mass > 0 ? state.velocity_m_s[vertex] : Vec3{});
  }
  body.loads->hold_all(body.time_s, PlainRows<Real>{body.u_now[0].data(), 4},
                       PlainRows<Real>{body.v[0].data(), 4});
}

template <typename Real>
MotionState TetEngine<Real>::state() const {
  const Body& body = *body_;
  const std::size_t n = body.order.size();
  MotionState out{body.time_s, std::vector<Vec3>(n), std::vector<Vec3>(n)};
  for (std::size_t k = 0; k < n; ++k) {
    const Index vertex = body.order[k];
    out.displacement_m[vertex] = {body.u_now[k][0], body.u_now[k][1], body.u_now[k][2]};
    out.velocity_m_s[vertex] = {body.v[k][0], body.v[k][1], body.v[k][2]};
  }
  return out;
}

template <typename Real>
PlainReport TetEngine<Real>::step(double step_s, std::uint64_t steps, const PlainObserver& observer) {
  require(step_s > 0.0 && std::isfinite(step_s), "a finite step above zero");
  return body_->run(step_s, steps, observer);
}

template <typename Real>
const std::vector<Vec3>& TetEngine<Real>::group_forces() const {
  return body_->loads->group_forces();
}

template <typename Real>
void TetEngine<Real>::set_pad(std::span<const SupportFace> faces) {
  Body& body = *body_;
  body.loads->set_pad(faces, PlainPlaces{body.order, body.place, body.block_vertices, {}, true}, body.rest);
}

template <typename Real>
void TetEngine<Real>::move_pad(const Vec3& by_m) {
  body_->loads->move_pad(by_m);
}

template <typename Real>
Vec3 TetEngine<Real>::pad_force() const {
  return body_->loads->pad_force();
}

template <typename Real>
bool TetEngine<Real>::uses_avx2() const {
  return body_->use_avx2;
}

template <typename Real>
std::size_t TetEngine<Real>::bytes_per_step() const {
  const auto bytes = [](const auto& list) { return list.size() * sizeof(list[0]); };
  const Body& body = *body_;
  return bytes(body.packed.values) + bytes(body.packed.at) + bytes(body.steady) + bytes(body.inertia) +
         bytes(body.u_now) + bytes(body.u_next) + 2 * bytes(body.v);
}

template <typename Real>
std::size_t TetEngine<Real>::domains() const {
  return body_->domain_count;
}

template <typename Real>
std::size_t TetEngine<Real>::halo_vertices() const {
  return body_->packed.rows - body_->order.size();
}

template class TetEngine<float>;
template class TetEngine<double>;

}  // namespace palpate::dynamics

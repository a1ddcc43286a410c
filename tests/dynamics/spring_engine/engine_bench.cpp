// What a step of a body of springs costs, in one process: the plain engine in single and double precision, on
// one thread and two, with AVX2 and without; the engine that takes every force; objects that point to each
// other, as the thesis has them; Bullet's springs and its constraints of position; and what the memory could
// deliver. PALPATE_BENCH_LARGE=1 adds 1M vertices. docs/engine_speed.md says how to read it;
// tests/dynamics/spring_engine/speed_table.py makes its table.
//
// Counters: ns_per_spring of one step, the median by the wall clock; cpu_ns_per_spring, by the time that the
// first thread ran. Rows of ours carry the hash of the state after 100 steps from the same start.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <memory>
#include <numeric>
#include <thread>
#include <vector>

#include "core/base/large_pages.h"
#include "core/dynamics/integrators/integrator.h"
#include "core/dynamics/spring_engine/plain_engine.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/motion_cases.h"
#include "tests/support/pointer_springs.h"
#include "tests/support/step_timing.h"
#ifdef PALPATE_HAS_BULLET
#include "reference/bullet/mass_springs.h"
#include "reference/bullet/soft_body.h"
#endif

namespace palpate::dynamics {
namespace {

using testing_support::ObjectOrder;
using testing_support::PointerBody;
using testing_support::set_hash;
using testing_support::time_medians;

struct Body {
  MotionModel model;
  MotionState start;
  double step_s = 0.0;  ///< far below the bound: waves of 1 m/s cross an edge in 1 / cbrt(n)
};

/// A cube of 1 m with springs damped along their length and against the environment, thrown at random. Made
/// once a process: it takes a while at 1M vertices.
const Body& body_of(int cells) {
  static std::map<int, std::unique_ptr<Body>> made;
  std::unique_ptr<Body>& body = made[cells];
  if (body == nullptr) {
    const TetMesh mesh = build_kuhn_cube(cells, 0.25, 1);
    body = std::make_unique<Body>(Body{testing_support::make_free_body(mesh, 1e-3), {}, 0.0});
    for (const double mass : body->model.mass_kg)
      body->model.environment_damping_n_s_per_m.push_back(0.5 * mass);
    body->start = start_at_rest(body->model);
    body->start.velocity_m_s = testing_support::make_random_field(mesh.points.size(), 0.01, 1);
    body->step_s = 0.05 / std::cbrt(static_cast<double>(mesh.points.size()));
  }
  return *body;
}

double spring_count(const Body& body) {
  return static_cast<double>(body.model.elastic.springs.springs.size());
}

/// Times `take_steps(count)` (tests/support/step_timing.h).
template <typename TakeSteps>
void time_steps(benchmark::State& state, const Body& body, const TakeSteps& take_steps,
                bool starts_threads = false) {
  testing_support::time_steps_of(state, spring_count(body), "spring", take_steps, starts_threads);
  state.counters["vertices"] = static_cast<double>(body.model.mass_kg.size());
  state.counters["springs"] = spring_count(body);
}

constexpr std::uint64_t kStepsBefore = 100;

/// Of double precision after kStepsBefore; kept, since it takes a while at 1M vertices.
const MotionState& exact_state(const Body& body) {
  static std::map<const Body*, MotionState> known;
  const auto found = known.find(&body);
  if (found != known.end()) return found->second;
  PlainEngine<double> exact(body.model, {2});
  exact.set_state(body.start);
  exact.step(body.step_s, kStepsBefore);
  return known[&body] = exact.state();
}

/// |u - u of double precision| / |u of double precision| and the greatest distance in m, after kStepsBefore.
void count_error(benchmark::State& state, const Body& body, const MotionState& found) {
  const MotionState& expected = exact_state(body);
  double farthest = 0.0;
  for (std::size_t v = 0; v < found.displacement_m.size(); ++v)
    farthest = std::max(farthest, length(found.displacement_m[v] - expected.displacement_m[v]));
  state.counters["error_relative"] =
      testing_support::field_distance(found.displacement_m, expected.displacement_m) /
      testing_support::field_norm(expected.displacement_m);
  state.counters["error_m"] = farthest;
}

template <typename Real>
void time_plain(benchmark::State& state, const PlainOptions& options) {
  const Body& body = body_of(static_cast<int>(state.range(0)));
  PlainEngine<Real> engine(body.model, options);
  engine.set_state(body.start);
  engine.step(body.step_s, kStepsBefore);
  const MotionState before = engine.state();
  time_steps(
      state, body, [&](std::uint64_t steps) { engine.step(body.step_s, steps); }, true);
  set_hash(state, hash_state(before), engine.uses_avx2() ? "avx2" : "portable");
  state.counters["bytes_per_spring"] = static_cast<double>(engine.bytes_per_step()) / spring_count(body);
  state.counters["across"] = static_cast<double>(engine.springs_across()) / spring_count(body);
  if (std::is_same_v<Real, float> && options.threads == 1) count_error(state, body, before);
}

/// Range 0 is the number of cells a side, range 1 that of threads, here and below.
template <typename Real>
void bench_plain(benchmark::State& state) {
  PlainOptions options;
  options.threads = static_cast<int>(state.range(1));
  time_plain<Real>(state, options);
}

void bench_portable(benchmark::State& state) {
  PlainOptions options;
  options.portable = true;
  time_plain<float>(state, options);
}

void bench_every_force(benchmark::State& state) {
  const Body& body = body_of(static_cast<int>(state.range(0)));
  IntegratorOptions options;
  options.threads = static_cast<int>(state.range(1));
  Integrator integrator(body.model, options);
  MotionState at = body.start;
  for (std::uint64_t k = 0; k < kStepsBefore; ++k) integrator.step(at, body.step_s);
  const std::uint64_t hash = hash_state(at);
  time_steps(state, body, [&](std::uint64_t steps) {
    for (std::uint64_t k = 0; k < steps; ++k) integrator.step(at, body.step_s);
  });
  set_hash(state, hash, "");
}

void time_pointers(benchmark::State& state, ObjectOrder order) {
  const Body& body = body_of(static_cast<int>(state.range(0)));
  PointerBody<float> objects(body.model, order);
  objects.set_state(body.start);
  objects.step(body.step_s, 2);
  time_steps(state, body, [&](std::uint64_t steps) { objects.step(body.step_s, steps); });
}

void bench_pointers(benchmark::State& state) {
  time_pointers(state, ObjectOrder::kAsMade);
}

void bench_pointers_shuffled(benchmark::State& state) {
  time_pointers(state, ObjectOrder::kShuffled);
}

#ifdef PALPATE_HAS_BULLET
template <typename Bullet>
void time_bullet(benchmark::State& state, const Body& body, Bullet soft) {
  soft.set_velocities(body.start.velocity_m_s);
  soft.step(body.step_s);
  time_steps(state, body, [&](std::uint64_t steps) {
    for (std::uint64_t k = 0; k < steps; ++k) soft.step(body.step_s);
  });
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Springs in N/m with damping along them: those of the body, with the mean of its constants.
void bench_bullet_springs(benchmark::State& state) {
  const Body& body = body_of(static_cast<int>(state.range(0)));
  const MotionModel& model = body.model;
  time_bullet(state, body,
              reference::BulletSprings(
                  model.elastic.rest, model.elastic.springs, model.mass_kg,
                  {mean(model.elastic.springs.stiffness_n_per_m), mean(model.spring_damping_n_s_per_m)}));
}

reference::BulletBody make_constraints(const Body& body) {
  return {body.model.elastic.rest, body.model.elastic.springs, body.model.mass_kg, {}};
}

/// Constraints of position: a step as Bullet's world takes it, with the upkeep of its tree.
void bench_bullet_constraints_step(benchmark::State& state) {
  const Body& body = body_of(static_cast<int>(state.range(0)));
  time_bullet(state, body, make_constraints(body));
}

/// One sweep over the same constraints.
void bench_bullet_constraints_sweep(benchmark::State& state) {
  const Body& body = body_of(static_cast<int>(state.range(0)));
  reference::BulletBody soft = make_constraints(body);
  soft.set_velocities(body.start.velocity_m_s);
  soft.step(body.step_s);
  time_steps(state, body, [&](std::uint64_t steps) {
    for (std::uint64_t k = 0; k < steps; ++k) soft.sweep_links();
  });
}
#endif

/// a = b + s c over three arrays of range(0) MB each, with range(1) threads. Bytes are counted as STREAM
/// does: two reads and a write, without what the write fetches first.
void bench_triad(benchmark::State& state) {
  const std::size_t count = static_cast<std::size_t>(state.range(0)) * 250000;
  const auto threads = static_cast<std::size_t>(state.range(1));
  LargeVector<float> a(count, 0.0F);
  const LargeVector<float> b(count, 1.0F);
  const LargeVector<float> c(count, 2.0F);
  const auto part = [&](std::size_t t) {
    float* const to = a.data();
    const float* const one = b.data();
    const float* const other = c.data();
    for (std::size_t k = count * t / threads; k < count * (t + 1) / threads; ++k)
      to[k] = one[k] + 0.5F * other[k];
    benchmark::ClobberMemory();
  };
  const auto [wall, cpu] = time_medians(state, 30, [&] {
    std::vector<std::jthread> others;
    for (std::size_t t = 1; t < threads; ++t) others.emplace_back(part, t);
    part(0);
  });
  state.counters["gb_per_s"] = 12e-9 * static_cast<double>(count) / wall;
  state.counters["cpu_gb_per_s"] = 12e-9 * static_cast<double>(count) / cpu;
}

bool is_large_wanted() {
  const char* const large = std::getenv("PALPATE_BENCH_LARGE");
  return large != nullptr && *large == '1';
}

/// 1331, 10648, 103823 and, if they are wanted, 1030301 vertices.
void add_sizes(benchmark::internal::Benchmark* bench, int threads, bool up_to_100k = false) {
  for (const int cells : {10, 21, 46, 100}) {
    if (cells < 100 || (is_large_wanted() && !up_to_100k)) bench->Args({cells, threads});
  }
  bench->UseManualTime()->Iterations(1);
}

void on_one(benchmark::internal::Benchmark* bench) {
  add_sizes(bench, 1);
}

void on_one_and_two(benchmark::internal::Benchmark* bench) {
  for (const int threads : {1, 2}) add_sizes(bench, threads);
}

void up_to_100k(benchmark::internal::Benchmark* bench) {
  for (const int threads : {1, 2}) add_sizes(bench, threads, true);
}

BENCHMARK_TEMPLATE(bench_plain, float)->Apply(on_one_and_two);
BENCHMARK_TEMPLATE(bench_plain, double)->Apply(on_one_and_two);
BENCHMARK(bench_portable)->Apply(on_one);
BENCHMARK(bench_every_force)->Apply(up_to_100k);
BENCHMARK(bench_pointers)->Apply(on_one);
BENCHMARK(bench_pointers_shuffled)->Apply(on_one);
#ifdef PALPATE_HAS_BULLET
BENCHMARK(bench_bullet_springs)->Apply(on_one);
BENCHMARK(bench_bullet_constraints_step)->Apply(on_one);
BENCHMARK(bench_bullet_constraints_sweep)->Apply(on_one);
#endif
BENCHMARK(bench_triad)->Args({100, 1})->Args({100, 2})->UseManualTime()->Iterations(1);

}  // namespace
}  // namespace palpate::dynamics

// What a step of a body of springs costs: the plain engine in single and double precision, on one thread and
// two, and the engine that takes every force. Counter "ns_per_spring": of one step, the median. Each row
// carries the hash of its last state after 100 steps from the same start.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <vector>

#include "core/dynamics/integrator.h"
#include "core/dynamics/plain_engine.h"
#include "core/mesh/shapes.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/motion_cases.h"

namespace palpate::dynamics {
namespace {

struct Body {
  MotionModel model;
  MotionState start;
};

Body make_body(int cells) {
  const TetMesh mesh = build_kuhn_cube(cells, 0.25, 1);
  Body body{testing_support::make_free_body(mesh, 1e-3), {}};
  body.start = start_at_rest(body.model);
  body.start.velocity_m_s = testing_support::make_random_field(mesh.points.size(), 0.01, 1);
  return body;
}

double step_of(const Body& body) {
  const double n = static_cast<double>(body.model.mass_kg.size());
  return 0.05 / std::cbrt(n);  // far below the bound: waves of 1 m/s cross an edge in 1 / cbrt(n)
}

/// `seconds` holds one entry a measurement of `steps` steps; their median counts.
void report(benchmark::State& state, const Body& body, double steps, std::vector<double> seconds,
            std::uint64_t hash) {
  const auto middle = seconds.begin() + static_cast<std::ptrdiff_t>(seconds.size() / 2);
  std::nth_element(seconds.begin(), middle, seconds.end());
  const auto springs = static_cast<double>(body.model.elastic.springs.springs.size());
  state.counters["ns_per_spring"] = 1e9 * *middle / (steps * springs);
  state.counters["vertices"] = static_cast<double>(body.model.mass_kg.size());
  state.counters["springs"] = springs;
  std::array<char, 24> text{};
  std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(hash));
  state.SetLabel(text.data());
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Range 0: cells a side; 1: threads.
template <typename Real>
void bench_plain(benchmark::State& state) {
  const Body body = make_body(static_cast<int>(state.range(0)));
  PlainEngine<Real> engine(body.model, {static_cast<int>(state.range(1))});
  engine.set_state(body.start);
  const double step = step_of(body);
  engine.step(step, 100);
  const std::uint64_t hash = hash_state(engine.state());
  constexpr std::uint64_t kSteps = 20;
  std::vector<double> seconds;
  while (state.KeepRunning()) {
    const auto start = std::chrono::steady_clock::now();
    engine.step(step, kSteps);
    const double here = seconds_since(start);
    state.SetIterationTime(here);
    seconds.push_back(here);
  }
  report(state, body, kSteps, seconds, hash);
}

void bench_every_force(benchmark::State& state) {
  const Body body = make_body(static_cast<int>(state.range(0)));
  IntegratorOptions options;
  options.threads = static_cast<int>(state.range(1));
  Integrator integrator(body.model, options);
  MotionState at = body.start;
  const double step = step_of(body);
  for (int k = 0; k < 100; ++k) integrator.step(at, step);
  const std::uint64_t hash = hash_state(at);
  std::vector<double> seconds;
  while (state.KeepRunning()) {
    const auto start = std::chrono::steady_clock::now();
    integrator.step(at, step);
    const double here = seconds_since(start);
    state.SetIterationTime(here);
    seconds.push_back(here);
  }
  report(state, body, 1.0, seconds, hash);
}

void sizes(benchmark::internal::Benchmark* bench) {
  for (const int threads : {1, 2}) {
    for (const int cells : {10, 21, 46}) bench->Args({cells, threads});  // 1331, 10648, 103823 vertices
  }
  bench->UseManualTime();
}

BENCHMARK_TEMPLATE(bench_plain, float)->Apply(sizes);
BENCHMARK_TEMPLATE(bench_plain, double)->Apply(sizes);
BENCHMARK(bench_every_force)->Apply(sizes);

}  // namespace
}  // namespace palpate::dynamics

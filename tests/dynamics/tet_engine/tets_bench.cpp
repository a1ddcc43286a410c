// What a step of a continuum costs, in one process: the tet engine with linear tets and with the dilatation
// averaged at nodes and the shear over edges, each law, in single and double precision, on one thread and
// two, with AVX2 and without, undamped and damped; and the engine that takes every force. The triad of
// tests/dynamics/spring_engine/engine_bench.cpp says what the memory could deliver. docs/engine_speed.md says
// how to read it; tests/dynamics/tet_engine/tets_table.py makes its table.
//
// Counters: ns_per_tet of one step, the median by the wall clock; cpu_ns_per_tet, by the time that the first
// thread ran. Rows carry the hash of the state after 100 steps from the same start.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <tuple>

#include "core/dynamics/integrators/integrator.h"
#include "core/dynamics/tet_engine/tet_engine.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/motion_cases.h"
#include "tests/support/step_timing.h"

namespace palpate::dynamics {
namespace {

using testing_support::Continuum;

struct Body {
  MotionModel model;
  MotionState start;
  double step_s = 0.0;  ///< far below the bound
  double tets = 0.0;
};

constexpr std::uint64_t kStepsBefore = 100;

/// A cube of 1 m, thrown at random, with drag. Made once a process.
const Body& body_of(int cells, Continuum kind, StrainLaw law, bool is_damped) {
  static std::map<std::tuple<int, Continuum, StrainLaw, bool>, std::unique_ptr<Body>> made;
  std::unique_ptr<Body>& body = made[{cells, kind, law, is_damped}];
  if (body == nullptr) {
    const TetMesh mesh = build_kuhn_cube(cells, 0.25, 1);
    MotionModel model;
    model.mass_kg = build_lumped_masses(mesh, 1000.0);
    body = std::make_unique<Body>();
    body->model = testing_support::make_continuum(std::move(model), mesh, kind, law);
    body->model.strain_damping_s = is_damped ? 1e-3 : 0.0;
    for (const double mass : body->model.mass_kg)
      body->model.environment_damping_n_s_per_m.push_back(0.5 * mass);
    body->start = start_at_rest(body->model);
    body->start.velocity_m_s = testing_support::make_random_field(mesh.points.size(), 0.01, 1);
    body->step_s = 0.02 / std::cbrt(static_cast<double>(mesh.points.size()));
    body->tets = static_cast<double>(mesh.tets.size());
  }
  return *body;
}

template <typename Real, bool kPortable = false>
void time_engine(benchmark::State& state, Continuum kind, bool is_damped) {
  const Body& body =
      body_of(static_cast<int>(state.range(0)), kind, static_cast<StrainLaw>(state.range(2)), is_damped);
  PlainOptions options;
  options.threads = static_cast<int>(state.range(1));
  options.portable = kPortable;
  TetEngine<Real> engine(body.model, options);
  engine.set_state(body.start);
  engine.step(body.step_s, kStepsBefore);
  const std::uint64_t hash = hash_state(engine.state());
  testing_support::time_steps_of(
      state, body.tets, "tet", [&](std::uint64_t steps) { engine.step(body.step_s, steps); }, true);
  testing_support::set_hash(state, hash, engine.uses_avx2() ? "avx2" : "portable");
  state.counters["bytes_per_tet"] = static_cast<double>(engine.bytes_per_step()) / body.tets;
  state.counters["vertices"] = static_cast<double>(body.model.mass_kg.size());
  state.counters["tets"] = body.tets;
  state.counters["halo"] =
      static_cast<double>(engine.halo_vertices()) / static_cast<double>(body.model.mass_kg.size());
}

template <typename Real>
void bench_tets(benchmark::State& state) {
  time_engine<Real>(state, Continuum::kTets, false);
}

template <typename Real>
void bench_tets_damped(benchmark::State& state) {
  time_engine<Real>(state, Continuum::kTets, true);
}

template <typename Real>
void bench_tets_portable(benchmark::State& state) {
  time_engine<Real, true>(state, Continuum::kTets, false);
}

template <typename Real>
void bench_edge_node(benchmark::State& state) {
  time_engine<Real>(state, Continuum::kEdgeNode, false);
}

template <typename Real>
void bench_edge_node_portable(benchmark::State& state) {
  time_engine<Real, true>(state, Continuum::kEdgeNode, false);
}

/// Integrator, as it steps the same body.
void time_general(benchmark::State& state, Continuum kind) {
  const Body& body =
      body_of(static_cast<int>(state.range(0)), kind, static_cast<StrainLaw>(state.range(2)), false);
  Integrator integrator(body.model, {});
  MotionState at = body.start;
  testing_support::time_steps_of(
      state, body.tets, "tet",
      [&](std::uint64_t steps) {
        for (std::uint64_t k = 0; k < steps; ++k) integrator.step(at, body.step_s);
      },
      false);
}

void bench_general_tets(benchmark::State& state) {
  time_general(state, Continuum::kTets);
}

void bench_general_edge_node(benchmark::State& state) {
  time_general(state, Continuum::kEdgeNode);
}

/// Cells a side (1331, 10648 and 103823 vertices), threads, law.
template <int kThreads>
void add_rows(benchmark::internal::Benchmark* bench) {
  for (const int cells : {10, 21, 46}) {
    for (int threads = 1; threads <= kThreads; ++threads) {
      for (const int law : {0, 1, 2}) bench->Args({cells, threads, law});
    }
  }
  bench->UseManualTime()->Iterations(1);
}

void up_to_10k(benchmark::internal::Benchmark* bench) {
  for (const int cells : {10, 21}) {
    for (const int law : {0, 1, 2}) bench->Args({cells, 1, law});
  }
  bench->UseManualTime()->Iterations(1);
}

BENCHMARK_TEMPLATE(bench_tets, float)->Apply(add_rows<2>);
BENCHMARK_TEMPLATE(bench_tets, double)->Apply(add_rows<2>);
BENCHMARK_TEMPLATE(bench_tets_damped, float)->Apply(add_rows<1>);
BENCHMARK_TEMPLATE(bench_tets_portable, float)->Apply(add_rows<1>);
BENCHMARK_TEMPLATE(bench_edge_node, float)->Apply(add_rows<2>);
BENCHMARK_TEMPLATE(bench_edge_node, double)->Apply(add_rows<2>);
BENCHMARK_TEMPLATE(bench_edge_node_portable, float)->Apply(add_rows<1>);
BENCHMARK(bench_general_tets)->Apply(up_to_10k);
BENCHMARK(bench_general_edge_node)->Apply(up_to_10k);

}  // namespace
}  // namespace palpate::dynamics

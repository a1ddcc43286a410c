// What a sweep of XPBD costs, in one process: one constraint at a time, in lanes on every processor, in lanes
// with AVX2; springs, linear tets of each law, and the dilatation averaged at nodes with the shear over
// edges; undamped and damped. A row is a whole step with one sweep, without what is out of balance every
// 32nd step, so that what a step does besides is in it.
//
// Counters: ns_per_spring or ns_per_tet of one step, the median by the wall clock; cpu_ns_per_..., by the
// time that the thread ran. Labels carry the hash of the state after 100 steps from the same start.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <tuple>
#include <utility>
#include <vector>

#include "core/dynamics/integrators/position_step.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/motion_cases.h"
#include "tests/support/step_timing.h"

namespace palpate::dynamics {
namespace {

using testing_support::Continuum;

/// What resists.
enum class Kind { kSprings, kTetsCorotated, kTetsStable, kEdgeNodeCorotated, kEdgeNodeStable };

struct SweptBody {
  MotionModel model;
  MotionState start;
  double parts = 0.0;
  const char* part = "tet";
};

/// A cube of 1 m, thrown at random, with drag. Made once a process.
const SweptBody& swept_body(int cells, Kind kind, bool is_damped) {
  static std::map<std::tuple<int, Kind, bool>, std::unique_ptr<SweptBody>> made;
  std::unique_ptr<SweptBody>& body = made[{cells, kind, is_damped}];
  if (body != nullptr) return *body;
  body = std::make_unique<SweptBody>();
  const TetMesh mesh = build_kuhn_cube(cells, 0.25, 1);
  body->parts = static_cast<double>(mesh.tets.size());
  if (kind == Kind::kSprings) {
    body->model = testing_support::make_free_body(mesh, is_damped ? 1e-3 : 0.0);
    if (!is_damped) body->model.spring_damping_n_s_per_m.clear();
    body->parts = static_cast<double>(body->model.elastic.springs.springs.size());
    body->part = "spring";
  } else {
    const bool is_tets = kind == Kind::kTetsCorotated || kind == Kind::kTetsStable;
    const bool is_stable = kind == Kind::kTetsStable || kind == Kind::kEdgeNodeStable;
    MotionModel model;
    model.mass_kg = build_lumped_masses(mesh, 1000.0);
    body->model = testing_support::make_continuum(
        std::move(model), mesh, is_tets ? Continuum::kTets : Continuum::kEdgeNode,
        is_stable ? StrainLaw::kStableNeoHookean : StrainLaw::kCorotated);
    body->model.strain_damping_s = is_damped ? 1e-3 : 0.0;
  }
  for (const double mass : body->model.mass_kg)
    body->model.environment_damping_n_s_per_m.push_back(0.5 * mass);
  body->start = start_at_rest(body->model);
  body->start.velocity_m_s = testing_support::make_random_field(mesh.points.size(), 0.01, 1);
  return *body;
}

/// Steps of one sweep.
class Stepper {
 public:
  Stepper(const SweptBody& body, PositionKernel kernel)
      : forces_(body.model, 1),
        step_(forces_, {1, 0.0}, kernel),
        state_(body.start),
        next_(state_.displacement_m.size()),
        step_s_(0.1 / std::cbrt(static_cast<double>(next_.size()))) {}

  void take(std::uint64_t steps) {
    for (std::uint64_t k = 0; k < steps; ++k) {
      step_.find_displacement(forces_, state_, step_s_, next_);
      for (std::size_t v = 0; v < next_.size(); ++v)
        state_.velocity_m_s[v] = (1.0 / step_s_) * (next_[v] - state_.displacement_m[v]);
      state_.displacement_m.swap(next_);
      state_.time_s += step_s_;
    }
  }
  std::uint64_t hash() const { return hash_state(state_); }

 private:
  MotionForces forces_;
  PositionStep step_;
  MotionState state_;
  std::vector<Vec3> next_;
  double step_s_;
};

template <PositionKernel kKernel>
void bench_sweep(benchmark::State& state) {
  const SweptBody& body =
      swept_body(static_cast<int>(state.range(0)), static_cast<Kind>(state.range(1)), state.range(2) != 0);
  Stepper stepper(body, kKernel);
  stepper.take(100);
  const std::uint64_t hash = stepper.hash();
  testing_support::time_steps_of(
      state, body.parts, body.part, [&](std::uint64_t steps) { stepper.take(steps); }, false);
  testing_support::set_hash(state, hash, "");
  state.counters["vertices"] = static_cast<double>(body.model.mass_kg.size());
}

/// Cells a side (1331 and 10648 vertices), kind, damped.
void add_sweeps(benchmark::internal::Benchmark* bench) {
  for (const int cells : {10, 21}) {
    for (int kind = 0; kind <= static_cast<int>(Kind::kEdgeNodeStable); ++kind) {
      for (const int is_damped : {0, 1}) bench->Args({cells, kind, is_damped});
    }
  }
  bench->UseManualTime()->Iterations(1);
}

BENCHMARK_TEMPLATE(bench_sweep, PositionKernel::kSingle)->Apply(add_sweeps);
BENCHMARK_TEMPLATE(bench_sweep, PositionKernel::kPortable)->Apply(add_sweeps);
BENCHMARK_TEMPLATE(bench_sweep, PositionKernel::kBest)->Apply(add_sweeps);

}  // namespace
}  // namespace palpate::dynamics

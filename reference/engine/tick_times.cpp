#include "reference/engine/tick_times.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/dynamics/spring_engine/plain_engine.h"
#include "core/dynamics/tet_engine/tet_engine.h"
#include "core/mesh/geometry.h"

namespace palpate::reference {
namespace {

constexpr double kEscapeRatio = 1000.0;

/// How far a vertex may go, in m.
double find_escape(const dynamics::MotionModel& model) {
  const BoundingBox box = bounding_box(model.elastic.rest);
  const Vec3 size = box.high - box.low;
  return kEscapeRatio * std::max({size.x, size.y, size.z, 1e-3});
}

void take_times(const TickClock& clock, TickRun& out) {
  if (out.diverged) out.diverged_s = clock.seconds_of_running();
  out.force_n.resize(clock.ticks());
  out.seconds = clock.seconds();
  out.first_tick_s = clock.ticks() > 0 ? clock.seconds_of(0) : 0.0;
}

/// PlainEngine or TetEngine.
template <typename Engine>
TickRun run_engine(const dynamics::MotionModel& model, const TickOptions& options) {
  const Stopwatch making;
  dynamics::PlainOptions own;
  own.threads = options.integrator.threads;
  own.speed_limit_m_s = options.integrator.speed_limit_m_s;
  own.escape_m = find_escape(model);
  Engine engine(model, own);
  const TickLoop& loop = options.loop;
  const std::uint64_t all = loop.warm_ticks + loop.ticks;
  TickRun out;
  out.force_n.resize(all);
  TickClock clock(loop);
  out.prepare_s = making.seconds();
  clock.start();
  const auto report = engine.step(loop.tick_s / static_cast<double>(options.steps_per_tick),
                                  all * options.steps_per_tick, [&](std::uint64_t step) {
                                    if (step % options.steps_per_tick != 0) return;
                                    out.force_n[clock.ticks()] = engine.group_forces()[options.tool];
                                    clock.end_tick();
                                  });
  out.diverged = report.diverged;
  take_times(clock, out);
  out.state = engine.state();
  return out;
}

/// Whether all displacements and speeds are finite, and no vertex has gone too far.
bool is_within(const dynamics::MotionState& state, double escape_m) {
  double farthest_sq = 0.0;
  double sum = 0.0;  // keeps what is not finite
  for (std::size_t v = 0; v < state.displacement_m.size(); ++v) {
    const double away_sq = length_sq(state.displacement_m[v]);
    farthest_sq = std::max(farthest_sq, away_sq);
    sum += away_sq + length_sq(state.velocity_m_s[v]);
  }
  return std::isfinite(sum) && farthest_sq <= escape_m * escape_m;
}

void add_step(const dynamics::StepReport& step, TickRun& out) {
  out.solver_iterations += step.iterations;
  out.steps_unsolved += step.solved ? 0 : 1;
  if (step.residual_relative)
    out.residual_worst = std::max(out.residual_worst.value_or(0.0), *step.residual_relative);
}

TickRun run_integrator(const dynamics::MotionModel& model, const TickOptions& options) {
  const Stopwatch making;
  dynamics::Integrator integrator(model, options.integrator);
  dynamics::MotionForces& forces = integrator.forces();
  const double escape_m = find_escape(model);
  const TickLoop& loop = options.loop;
  const std::uint64_t all = loop.warm_ticks + loop.ticks;
  const double step_s = loop.tick_s / static_cast<double>(options.steps_per_tick);
  TickRun out;
  out.state = start_at_rest(model);
  forces.impose(out.state.time_s, out.state.displacement_m, out.state.velocity_m_s);
  out.force_n.resize(all);
  TickClock clock(loop);
  out.prepare_s = making.seconds();
  clock.start();
  while (clock.ticks() < all && !out.diverged) {
    for (std::uint64_t k = 0; k < options.steps_per_tick; ++k)
      add_step(integrator.step(out.state, step_s), out);
    out.force_n[clock.ticks()] = forces.group_forces(out.state)[options.tool];
    out.diverged = !is_within(out.state, escape_m);
    if (!out.diverged) clock.end_tick();
  }
  take_times(clock, out);
  return out;
}

}  // namespace

TickRun run_ticks(const dynamics::MotionModel& model, const TickOptions& options) {
  require(options.loop.ticks > 0 && options.steps_per_tick > 0 && options.tool < model.loads.size(),
          "ticks, steps and a tool");
  const bool single = options.single_precision;
  switch (options.engine) {
    case EngineChoice::kPlain:
      return single ? run_engine<dynamics::PlainEngine<float>>(model, options)
                    : run_engine<dynamics::PlainEngine<double>>(model, options);
    case EngineChoice::kTets:
      return single ? run_engine<dynamics::TetEngine<float>>(model, options)
                    : run_engine<dynamics::TetEngine<double>>(model, options);
    case EngineChoice::kGeneral:
      require(!single, "the general engine computes in double precision");
      return run_integrator(model, options);
    case EngineChoice::kAuto:
      break;
  }
  throw ContractError("an engine that is chosen");
}

}  // namespace palpate::reference

#include "reference/engine/tick_times.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/dynamics/spring_engine/plain_engine.h"
#include "core/mesh/geometry.h"

namespace palpate::reference {
namespace {

constexpr double kEscapeRatio = 1000.0;

template <typename Real>
TickRun run(const dynamics::MotionModel& model, const TickOptions& options) {
  const BoundingBox box = bounding_box(model.elastic.rest);
  const Vec3 size = box.high - box.low;
  dynamics::PlainOptions own;
  own.threads = options.threads;
  own.escape_m = kEscapeRatio * std::max({size.x, size.y, size.z, 1e-3});
  dynamics::PlainEngine<Real> engine(model, own);
  const TickLoop& loop = options.loop;
  const std::uint64_t all = loop.warm_ticks + loop.ticks;
  TickRun out;
  out.force_n.resize(all);
  TickClock clock(loop);
  clock.start();
  const auto report = engine.step(loop.tick_s / static_cast<double>(options.steps_per_tick),
                                  all * options.steps_per_tick, [&](std::uint64_t step) {
                                    if (step % options.steps_per_tick != 0) return;
                                    out.force_n[clock.ticks()] = engine.group_forces()[options.tool];
                                    clock.end_tick();
                                  });
  out.diverged = report.diverged;
  if (out.diverged) out.diverged_s = clock.seconds_of_running();
  out.force_n.resize(clock.ticks());
  out.seconds = clock.seconds();
  out.state = engine.state();
  return out;
}

}  // namespace

TickRun run_ticks(const dynamics::MotionModel& model, const TickOptions& options) {
  require(options.loop.ticks > 0 && options.steps_per_tick > 0 && options.tool < model.loads.size(),
          "ticks, steps and a tool");
  return options.single_precision ? run<float>(model, options) : run<double>(model, options);
}

}  // namespace palpate::reference

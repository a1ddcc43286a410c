// reduced.modal_ticks.

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "reference/door/moving_body.h"
#include "reference/door/request_options.h"
#include "reference/elastic_models/tick_report.h"
#include "reference/reduced/modes/modal_body.h"
#include "reference/reduced/modes/modal_options.h"
#include "reference/reduced/modes/modal_run.h"

namespace palpate::reference {
namespace {

using nlohmann::json;

/// The tool's force at the end of each tick; `clock` has their times. A force that is not finite is the last.
std::vector<Vec3> tick_through(dynamics::ModalPhase& body, std::size_t group, const TickLoop& loop,
                               TickClock& clock) {
  const std::uint64_t all = loop.warm_ticks + loop.ticks;
  std::vector<Vec3> force_n(all);
  clock.start();
  for (std::uint64_t k = 0; k < all; ++k) {
    body.advance(loop.tick_s, static_cast<double>(k + 1) * loop.tick_s);
    force_n[k] = body.group_force(group);
    if (!is_finite(force_n[k])) break;
    clock.end_tick();
  }
  force_n.resize(clock.ticks());
  return force_n;
}

}  // namespace

Response run_modal_ticks(const Request& request) {
  json left = request.options;
  const TickLoop loop = take_tick_loop(left);
  const ModalBodyOptions options = take_modal_options(left);
  take_mesh_vertices(left);
  require_all_taken(left);
  MovingTask task = read_moving_task(request);
  MotionProblem& motion = task.body.motion;
  const std::size_t tool = find_only_tool(motion);
  Response response;
  note_large(motion.body.strain, request.method, response);
  motion.duration_s = loop.tick_s;
  const std::vector<LoadPhase> phases = find_phases(motion);
  std::size_t group = 1;
  while (phases.front().loads[group - 1] != tool) ++group;

  const Stopwatch making;
  const ModalBody body(task.mesh, motion, options.order, options.factor);
  const std::size_t nodes = body.space().nodes();
  dynamics::ModalPhase modes = body.build_phase(phases.front(), options.modal);
  modes.start({std::vector<Vec3>(nodes), std::vector<Vec3>(nodes)}, 0.0);
  const double identify_s = making.seconds();
  modes.prepare(loop.tick_s);
  const double setup_s = making.seconds();

  TickClock clock(loop);
  const std::vector<Vec3> force_n = tick_through(modes, group, loop, clock);
  const bool diverged = clock.ticks() < loop.warm_ticks + loop.ticks;
  const std::vector<double> seconds = clock.seconds();
  response.kernel_s = std::accumulate(seconds.begin(), seconds.end(), 0.0);
  response.report = {{"outcome", diverged ? "diverged" : "completed"},
                     {"kind", "ticks"},
                     {"integrator", "exponential"},
                     {"precision", "double"},
                     {"steps_per_tick", 1},
                     {"tick_s", loop.tick_s},
                     {"time_step_s", loop.tick_s},
                     {"identify_s", identify_s},
                     {"setup_s", setup_s},
                     {"first_tick_s", clock.ticks() > 0 ? clock.seconds_of(0) : 0.0},
                     {"modes", options.modal.modes},
                     {"mode_bytes", std::size_t{24} * nodes * options.modal.modes},
                     {"unknowns", 3 * nodes},
                     {"engine_threads", 1},
                     {"vertices", task.mesh.points.size()}};
  if (!seconds.empty()) add_tick_times(seconds, loop.tick_s, response.report);
  write_file_atomically(request.output, describe_tick_forces(force_n, loop.tick_s, diverged).dump() + "\n");
  return response;
}

}  // namespace palpate::reference

#include "reference/engine/tick_request.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/base/number_text.h"
#include "core/base/stopwatch.h"
#include "reference/door/json_file.h"
#include "reference/door/request_options.h"
#include "reference/engine/motion_setup.h"
#include "reference/engine/tick_times.h"

namespace palpate::reference {
namespace {

using nlohmann::json;

TickOptions take_tick_options(json& left) {
  TickOptions out;
  out.loop = take_tick_loop(left);
  out.steps_per_tick = static_cast<std::uint64_t>(take_whole(left, "steps_per_tick", 0, 100'000, 0));
  out.integrator.threads = static_cast<int>(take_whole(left, "engine_threads", 1, 64, 1));
  out.single_precision = take_choice(left, "precision", {"single", "double"}) == 0;
  return out;
}

/// Takes over what the setup chose, and how many steps fill a tick.
void take_setup(const MotionSetup& setup, std::size_t tool, TickOptions& options) {
  if (options.steps_per_tick == 0) options.steps_per_tick = setup.steps;
  const int threads = options.integrator.threads;
  options.integrator = setup.integrator;
  options.integrator.threads = threads;
  options.integrator.linear.threads = threads;
  options.engine = setup.engine;
  const std::vector<std::size_t>& loads = setup.phases.front().loads;
  options.tool = static_cast<std::size_t>(std::find(loads.begin(), loads.end(), tool) - loads.begin()) + 1;
}

std::string name_outcome(const TickRun& run, std::size_t inverted) {
  if (run.diverged) return "diverged";
  if (inverted > 0) return "inverted";
  return run.steps_unsolved > 0 ? "unsolved" : "completed";
}

json describe_run(const TickRun& run, const TickOptions& options, const MotionSetup& setup) {
  const dynamics::MotionModel& model = setup.phases.front().model;
  const std::size_t inverted = run.diverged ? 0 : count_volume(model, run.state).inverted;
  json out{{"outcome", name_outcome(run, inverted)},
           {"kind", "ticks"},
           {"engine", engine_name(options.engine)},
           {"integrator", dynamics::integrator_name(options.integrator.kind)},
           {"precision", options.single_precision ? "single" : "double"},
           {"steps_per_tick", options.steps_per_tick},
           {"fewest_steps_per_tick", setup.steps},
           {"tick_s", options.loop.tick_s},
           {"time_step_s", options.loop.tick_s / static_cast<double>(options.steps_per_tick)},
           {"stable_step_s", number_or_null(setup.stable.step_s)},
           {"engine_threads", options.integrator.threads},
           {"vertices", model.elastic.rest.size()},
           {"tets", model.tets.size()},
           {"springs", model.elastic.springs.springs.size()},
           {"laws", list_laws(model.elastic)},
           {"inverted_tets", run.diverged ? json(nullptr) : json(inverted)},
           {"first_tick_s", run.first_tick_s}};
  if (dynamics::is_implicit(options.integrator.kind)) {
    out["solver_iterations"] = run.solver_iterations;
    out["steps_unsolved"] = run.steps_unsolved;
    out["residual_worst"] = run.residual_worst ? number_or_null(*run.residual_worst) : json(nullptr);
  }
  return out;
}

void note_step(const MotionSetup& setup, const TickOptions& options, std::optional<double> wanted_s,
               Response& response) {
  const double step_s = options.loop.tick_s / static_cast<double>(options.steps_per_tick);
  if (step_s > setup.stable.step_s)
    response.notes.push_back("a time step of " + short_number(step_s) + " s is over the bound at rest, " +
                             short_number(setup.stable.step_s) + " s");
  if (wanted_s && step_s < *wanted_s * (1.0 - 1e-12))
    response.notes.push_back("steps of " + short_number(step_s) + " s fill a tick, in place of the scene's " +
                             short_number(*wanted_s) + " s");
}

}  // namespace

Response answer_ticks(MovingTask task, const Request& request, json& left) {
  const Stopwatch clock;
  TickOptions options = take_tick_options(left);
  require_all_taken(left);
  const std::size_t tool = find_only_tool(task.body.motion);
  MotionStepping& stepping = task.body.stepping;
  if (!dynamics::is_implicit(stepping.integrator)) stepping.time_step_s.reset();
  stepping.single_precision = options.single_precision;
  task.body.motion.duration_s = options.loop.tick_s;
  const MotionSetup setup = build_motion(task.body, task.mesh, request.threads);
  take_setup(setup, tool, options);
  const double identify_s = clock.seconds();
  const TickRun run = run_ticks(setup.phases.front().model, options);
  Response response;
  note_step(setup, options, stepping.time_step_s, response);
  response.kernel_s = std::accumulate(run.seconds.begin(), run.seconds.end(), run.diverged_s);
  response.report = describe_run(run, options, setup);
  response.report["identify_s"] = identify_s;
  response.report["setup_s"] = identify_s + run.prepare_s;
  if (!run.seconds.empty()) add_tick_times(run.seconds, options.loop.tick_s, response.report);
  write_file_atomically(request.output,
                        describe_tick_forces(run.force_n, options.loop.tick_s, run.diverged).dump() + "\n");
  return response;
}

}  // namespace palpate::reference

#include "reference/engine/engine_request.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/dynamics/stability/slow_rates.h"
#include "reference/door/json_file.h"
#include "reference/door/moving_body.h"
#include "reference/door/request_options.h"
#include "reference/elastic_models/motion_files.h"
#include "reference/elastic_models/tick_report.h"
#include "reference/engine/model_file.h"
#include "reference/engine/motion_replay.h"
#include "reference/engine/motion_setup.h"
#include "reference/engine/tick_request.h"

namespace palpate::reference {
namespace {

using nlohmann::json;

constexpr double kThesisTickS = 5e-3;  ///< the thesis takes one step at each tick of its timer (4.2.9)
constexpr std::int64_t kMostCount = 536'870'912;

/// Makes the folder ready for the rows and frames of a motion.
void prepare_folder(const Request& request, const MovingTask& task, const MotionSetup& setup,
                    const MotionOutput& output, double most_bytes) {
  const Strides strides(task.body.motion.samples, task.body.stepping.frames, setup.steps);
  const std::uint64_t frames = strides.frame == 0 ? 0 : setup.steps / strides.frame + 2;
  const std::uint64_t rows = setup.steps / strides.row + 2 + setup.phases.size();
  clear_folder(request.folder, task.mesh, output.files(), rows, frames, most_bytes);
}

Response answer_replay(MovingTask task, const Request& request, json& left,
                       const volatile std::sig_atomic_t* stop_flag) {
  const Stopwatch clock;
  const ReplayOptions options = take_replay_options(left);
  require_all_taken(left);
  if (options.frames > 0) task.body.stepping.frames = options.frames;
  const MotionSetup setup = build_motion(task.body, task.mesh, request.threads);
  const double setup_s = clock.seconds();
  MotionOutput output(request.folder, task.body.motion, task.mesh);
  output.watch_frozen(setup.frozen);
  Response response;
  response.notes = setup.notes;
  if (options.setup_only) {
    response.kernel_s = clock.seconds();
    response.report = {{"outcome", "set_up"}, {"time_step_s", setup.step_s}, {"steps_planned", setup.steps}};
    return response;
  }
  if (!request.folder.empty()) prepare_folder(request, task, setup, output, options.most_output_bytes);
  MotionStops stops;
  stops.stop_flag = stop_flag;
  if (options.stop_after_s > 0.0) stops.timeout_s = options.stop_after_s - clock.seconds();
  // Beside the answer, where a folder says that somebody waits for it.
  MotionProgress progress(
      request.folder.empty() ? std::filesystem::path() : request.output.parent_path() / "progress.json",
      setup, task.mesh);
  stops.progress = &progress;
  response.report = run_motion_setup(task.body, task.mesh, setup, stops, output);
  response.kernel_s = response.report.at("kernel_s").get<double>();
  response.report["tick_real_time_factor"] = setup.step_s / kThesisTickS;
  response.report["kind"] = "replay";
  response.report["setup_s"] = setup_s;
  response.report["frames_written"] = output.files().frame_count();
  output.files().finish();
  write_file_atomically(request.output,
                        describe_replay(output.files(), !request.folder.empty()).dump() + "\n");
  return response;
}

Response answer_rest(MovingTask task, const Request& request, json& left) {
  MotionStepping& stepping = task.body.stepping;
  const auto kind = take_option<std::string>(left, "spring_damping", &json::is_string,
                                             "scene, axial or isotropic", "scene");
  const std::int64_t decay_up_to = take_whole(left, "decay_up_to_vertices", 0, kMostCount, 20'000);
  require_all_taken(left);
  if (kind != "scene") stepping.spring_damping = dynamics::parse_spring_damping(kind);
  stepping.allow_unstable = true;
  stepping.engine = EngineChoice::kAuto;
  stepping.single_precision = false;
  const Stopwatch clock;
  const MotionSetup setup = build_motion(task.body, task.mesh, request.threads);
  const dynamics::MotionModel& model = setup.phases.front().model;
  Response response;
  response.report = {{"outcome", "completed"},
                     {"kind", "rest"},
                     {"integrator", dynamics::integrator_name(setup.integrator.kind)},
                     {"spring_damping", dynamics::spring_damping_name(model.spring_damping)},
                     {"time_step_s", setup.step_s},
                     {"stable_step_s", number_or_null(setup.stable.step_s)},
                     {"stable_by", setup.stable_by},
                     {"stability_margin", number_or_null(setup.stable.step_s / setup.step_s)},
                     {"stiffness_max_per_s2", number_or_null(setup.stable.stiffness_max_per_s2)},
                     {"damping_max_per_s", number_or_null(setup.stable.damping_max_per_s)},
                     {"vertices", task.mesh.points.size()},
                     {"springs", model.elastic.springs.springs.size()},
                     {"stable_step_kernel_s", clock.seconds()},
                     {"slowest_decay_s", nullptr}};
  json written{{"schema", "palpate/engine/1"},
               {"kind", "rest"},
               {"columns", {"rate_per_s", "frequency_per_s"}},
               {"rows", json::array()}};
  if (task.mesh.points.size() <= static_cast<std::size_t>(decay_up_to)) {
    // The body with nothing that moves it: what is there when all tools have let go.
    dynamics::MotionModel still = model;
    still.loads.resize(1);
    const dynamics::SlowRates rates = dynamics::find_slow_rates(still, 6, request.threads);
    if (rates.converged) response.report["slowest_decay_s"] = number_or_null(rates.slowest_decay_s());
    for (const std::complex<double>& each : rates.lambda_per_s)
      written["rows"].push_back({each.real(), each.imag()});
  }
  response.kernel_s = clock.seconds();
  write_file_atomically(request.output, written.dump() + "\n");
  return response;
}

/// The body's model as a file for other simulators.
Response answer_model(const MovingTask& task, const Request& request, const json& left) {
  require_all_taken(left);
  if (!task.body.model.options.value("frozen", "").empty())
    throw InputError("model: frozen", 0, "a whole model: what is written has no part that is held at rest",
                     "one");
  const Stopwatch clock;
  Response response;
  const dynamics::MotionModel model =
      build_free_body(task.body, task.mesh, build_elastic(task.body, task.mesh, response));
  response.kernel_s = clock.seconds();
  response.report["outcome"] = "completed";
  response.report["vertices"] = task.mesh.points.size();
  json written = model_to_json(task.mesh, model);
  const BoundaryProblem& body = task.body.motion.body;
  written["schema"] = "palpate/model/1";
  written["method"] = task.body.model.method;
  written["options"] = task.body.model.options;
  written["strain"] = body.strain == StrainSize::kLarge ? "large" : "small";
  written["material"] = {{"young_modulus_pa", body.material.young_modulus_pa},
                         {"poisson_ratio", body.material.poisson_ratio},
                         {"density_kg_m3", body.material.density_kg_m3}};
  write_file_atomically(request.output, written.dump() + "\n");
  return response;
}

}  // namespace

Response answer_engine_request(const Request& request, const volatile std::sig_atomic_t* stop_flag) {
  MovingTask task = read_moving_task(request);
  json left = request.options;
  take_mesh_vertices(left);
  if (request.method == "engine.replay") return answer_replay(task, request, left, stop_flag);
  if (request.method == "engine.rest") return answer_rest(std::move(task), request, left);
  if (request.method == "engine.ticks") return answer_ticks(std::move(task), request, left);
  if (request.method == "engine.model") return answer_model(task, request, left);
  throw InputError("method", 0, "engine.replay, engine.rest, engine.ticks or engine.model", request.method);
}

}  // namespace palpate::reference

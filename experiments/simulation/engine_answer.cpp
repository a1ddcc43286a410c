#include "experiments/simulation/engine_answer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/dynamics/stability/slow_rates.h"
#include "core/mesh/io/medit.h"
#include "experiments/scene_reader/scene_problem.h"
#include "experiments/simulation/motion_returns.h"
#include "experiments/simulation/motion_setup.h"
#include "experiments/simulation/simulate_motion.h"
#include "experiments/simulation/tick_times.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using reference::Request;
using reference::Response;

constexpr double kThesisTickS = 5e-3;  ///< the thesis takes one step at each tick of its timer (4.2.9)
constexpr std::size_t kMostSamples = 1000;

/// What a request asks of which body.
struct EngineTask {
  Scene placed;
  TetMesh mesh;
};

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

json number_or_null(double value) {
  return std::isfinite(value) ? json(value) : json(nullptr);
}

template <typename T>
T take(const Request& request, const char* key) {
  if (!request.options.contains(key))
    throw InputError("options", 0, std::string("the key \"") + key + "\"", "none");
  try {
    return request.options.at(key).get<T>();
  } catch (const json::exception&) {
    throw InputError("options", 0, std::string("another type for \"") + key + "\"",
                     request.options.at(key).dump());
  }
}

EngineTask read_task(const Request& request) {
  EngineTask task;
  task.mesh = read_medit(request.input).mesh;
  Scene scene = read_scene(request.problem);
  if (!scene.is_dynamic) throw InputError(request.problem.string(), 0, "a dynamic scene", "a static one");
  task.placed = place_scene(std::move(scene), task.mesh);
  return task;
}

/// The points that the tools push, as probes after the scene's own.
void add_tool_probes(Scene& placed) {
  for (const SceneLoad& load : placed.loads) {
    if (load.kind == SceneLoad::Kind::kDisplace && load.region.kind == Region::Kind::kSphere)
      placed.dynamic.probes_m.push_back(load.region.center);
  }
}

/// The text of a CSV as columns and rows; an empty cell is null.
void add_table(const std::string& csv, json& out) {
  out["columns"] = json::array();
  out["rows"] = json::array();
  std::size_t at = 0;
  bool is_head = true;
  while (at < csv.size()) {
    const std::size_t end = csv.find('\n', at);
    json row = json::array();
    for (std::size_t k = at; k <= end;) {
      const std::size_t stop = std::min(csv.find(',', k), end);
      const std::string cell = csv.substr(k, stop - k);
      row.push_back(is_head ? json(cell) : (cell.empty() ? json(nullptr) : json(std::stod(cell))));
      k = stop + 1;
    }
    if (is_head) {
      out["columns"] = row;
    } else {
      out["rows"].push_back(row);
    }
    is_head = false;
    at = end + 1;
  }
}

/// To a micrometre's thousandth: for pictures.
json rounded(const std::vector<Vec3>& field) {
  json out = json::array();
  for (const Vec3& u : field) {
    for (const double x : {u.x, u.y, u.z}) out.push_back(std::round(1e9 * x) / 1e9);
  }
  return out;
}

Response answer_replay(EngineTask task, const Request& request) {
  add_tool_probes(task.placed);
  const MotionSetup setup = build_motion(task.placed, task.mesh, load_registry(), request.threads);
  MotionOutput output({}, task.placed, task.mesh);
  Response response;
  response.notes = setup.notes;
  response.report = run_motion_setup(task.placed, task.mesh, setup, {}, output);
  response.kernel_s = response.report.at("kernel_s").get<double>();
  response.report["tick_real_time_factor"] = setup.step_s / kThesisTickS;
  const std::vector<MotionReturn> returns = find_returns(task.placed, output.levels());
  response.report["returns"] = returns_to_json(returns);
  json written{{"schema", "palpate/engine/1"}};
  add_table(output.history_csv(), written);
  written["frames"] = json::array();
  for (const MotionFrame& frame : output.frames())
    written["frames"].push_back(
        {{"time_s", frame.time_s}, {"displacement_m", rounded(frame.displacement_m)}});
  write_file_atomically(request.output, written.dump() + "\n");
  return response;
}

Response answer_rest(EngineTask task, const Request& request) {
  const auto kind = take<std::string>(request, "spring_damping");
  if (kind != "scene") task.placed.dynamic.spring_damping = dynamics::parse_spring_damping(kind);
  task.placed.dynamic.allow_unstable = true;
  task.placed.dynamic.engine = EngineChoice::kAuto;
  task.placed.dynamic.single_precision = false;
  const auto start = std::chrono::steady_clock::now();
  const MotionSetup setup = build_motion(task.placed, task.mesh, load_registry(), request.threads);
  const dynamics::MotionModel& model = setup.phases.front().model;
  Response response;
  response.report = {{"outcome", "completed"},
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
                     {"stable_step_kernel_s", seconds_since(start)},
                     {"slowest_decay_s", nullptr}};
  json written{{"schema", "palpate/engine/1"}, {"columns", {"rate_per_s", "frequency_per_s"}}};
  written["rows"] = json::array();
  if (task.mesh.points.size() <= take<std::uint64_t>(request, "decay_up_to_vertices")) {
    // The body with nothing that moves it: what is there when all tools have let go.
    dynamics::MotionModel still = model;
    still.loads.resize(1);
    const dynamics::SlowRates rates = dynamics::find_slow_rates(still, 6, request.threads);
    if (rates.converged) response.report["slowest_decay_s"] = number_or_null(rates.slowest_decay_s());
    for (const std::complex<double>& each : rates.lambda_per_s)
      written["rows"].push_back({each.real(), each.imag()});
  }
  response.kernel_s = seconds_since(start);
  write_file_atomically(request.output, written.dump() + "\n");
  return response;
}

/// The only tool of a motion whose loads stay: its group of loads.
std::size_t find_tool(const Scene& placed, const MotionSetup& setup) {
  for (const SceneLoad& load : placed.loads) {
    if (load.from_s > 0.0 || load.until_s)
      throw InputError(load.where, 0, "a load that is there all the time", "one that comes or goes");
  }
  const std::vector<std::size_t>& loads = setup.phases.front().loads;
  std::vector<std::size_t> tools;
  for (std::size_t k = 0; k < loads.size(); ++k) {
    if (placed.loads[loads[k]].kind == SceneLoad::Kind::kDisplace) tools.push_back(k + 1);
  }
  if (tools.size() != 1)
    throw InputError(placed.file.string(), 0, "one tool (displace)", std::to_string(tools.size()));
  return tools.front();
}

/// The mean force over the last tenth of the ticks, and how far single ticks are from it.
void add_force(const TickRun& run, json& report) {
  const std::size_t count = std::max<std::size_t>(1, run.force_n.size() / 10);
  Vec3 mean;
  for (std::size_t k = run.force_n.size() - count; k < run.force_n.size(); ++k)
    mean = mean + (1.0 / static_cast<double>(count)) * run.force_n[k];
  double spread = 0.0;
  for (std::size_t k = run.force_n.size() - count; k < run.force_n.size(); ++k)
    spread = std::max(spread, length(run.force_n[k] - mean));
  report["held_force_n"] = {mean.x, mean.y, mean.z};
  report["held_force_size_n"] = length(mean);
  report["held_force_spread_n"] = spread;
}

void add_times(const TickRun& run, double tick_s, json& report) {
  const TickTimes times = describe_ticks(run.seconds, tick_s);
  report["ticks"] = run.seconds.size();
  report["tick_p50_s"] = times.p50_s;
  report["tick_p99_s"] = times.p99_s;
  report["tick_p99_9_s"] = times.p99_9_s;
  report["tick_worst_s"] = times.worst_s;
  report["tick_mean_s"] = times.mean_s;
  report["ticks_missed"] = times.missed;
  report["bucket_ends_s"] = times.bucket_ends_s;
  report["buckets"] = times.buckets;
}

Response answer_ticks(EngineTask task, const Request& request) {
  const auto tick_s = take<double>(request, "tick_s");
  task.placed.dynamic.time_step_s.reset();
  task.placed.dynamic.duration_s = tick_s;
  task.placed.dynamic.engine = EngineChoice::kPlain;
  const MotionSetup setup = build_motion(task.placed, task.mesh, load_registry(), request.threads);
  TickOptions options;
  options.tick_s = tick_s;
  options.steps_per_tick = take<std::uint64_t>(request, "steps_per_tick");
  if (options.steps_per_tick == 0) options.steps_per_tick = setup.steps;
  options.ticks = take<std::uint64_t>(request, "ticks");
  options.warm_ticks = options.ticks / 10;
  options.threads = take<int>(request, "engine_threads");
  options.single_precision = take<std::string>(request, "precision") == "single";
  options.paced = take<bool>(request, "paced");
  options.tool = find_tool(task.placed, setup);
  const TickRun run = run_ticks(setup.phases.front().model, options);
  Response response;
  const double step_s = tick_s / static_cast<double>(options.steps_per_tick);
  if (step_s > setup.stable.step_s)
    response.notes.push_back("a time step of " + short_number(step_s) + " s is over the bound at rest, " +
                             short_number(setup.stable.step_s) + " s");
  response.kernel_s = std::accumulate(run.seconds.begin(), run.seconds.end(), run.diverged_s);
  response.report = {{"outcome", run.diverged ? "diverged" : "completed"},
                     {"steps_per_tick", options.steps_per_tick},
                     {"fewest_steps_per_tick", setup.steps},
                     {"tick_s", tick_s},
                     {"time_step_s", step_s},
                     {"stable_step_s", number_or_null(setup.stable.step_s)},
                     {"engine_threads", options.threads},
                     {"vertices", task.mesh.points.size()},
                     {"springs", setup.phases.front().model.elastic.springs.springs.size()}};
  if (!run.seconds.empty()) add_times(run, tick_s, response.report);
  if (!run.diverged) add_force(run, response.report);
  json written{{"schema", "palpate/engine/1"}, {"columns", {"time_s", "fx_n", "fy_n", "fz_n"}}};
  written["rows"] = json::array();
  const std::size_t stride = std::max<std::size_t>(1, run.force_n.size() / kMostSamples);
  for (std::size_t k = 0; k < run.force_n.size(); k += stride) {
    const Vec3& f = run.force_n[k];
    written["rows"].push_back({static_cast<double>(k + 1) * tick_s, f.x, f.y, f.z});
  }
  write_file_atomically(request.output, written.dump() + "\n");
  return response;
}

}  // namespace

Response answer_engine_request(const Request& request) {
  if (request.contest != "engine") throw InputError("contest", 0, "engine", "\"" + request.contest + "\"");
  EngineTask task = read_task(request);
  if (request.method == "engine.replay") return answer_replay(std::move(task), request);
  if (request.method == "engine.rest") return answer_rest(std::move(task), request);
  if (request.method == "engine.ticks") return answer_ticks(std::move(task), request);
  throw InputError("method", 0, "engine.replay, engine.rest or engine.ticks", request.method);
}

}  // namespace palpate::experiments

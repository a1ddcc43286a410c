#include "experiments/trials/motion_trial.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/mesh/io/medit.h"
#include "experiments/contests/moving_task.h"
#include "experiments/files/output_file.h"
#include "experiments/scene_reader/scene_motion.h"
#include "experiments/scene_reader/scene_problem.h"
#include "reference/door/json_file.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

constexpr std::size_t kLargestAnswer = std::size_t{256} << 20U;
constexpr std::size_t kAnswerDepth = 16;
constexpr double kSameTime = 1e-9;      // of the duration: rows of that distance are at one time
constexpr double kSetupGraceS = 1.0;    // s
constexpr double kPicturesPerS = 60.0;  // of a simulated second
constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

/// What `fine` has at a time between its rows `k` and `k` + 1.
double between(const ProbeHistory& fine, std::size_t k, std::size_t column, double time_s) {
  const double share = (time_s - fine.time_s[k]) / (fine.time_s[k + 1] - fine.time_s[k]);
  return (1.0 - share) * fine.row[k][column] + share * fine.row[k + 1][column];
}

/// The root of `off_sq` over `size_sq`; 0 where nothing is off, infinite where that is no number.
double relative_size(double off_sq, double size_sq) {
  if (off_sq == 0.0) return 0.0;
  const double share = std::sqrt(off_sq / size_sq);
  return std::isnan(share) ? std::numeric_limits<double>::infinity() : share;
}

/// As run_moving_task, but a run that was ended by its time-out is one of the outcomes.
ContestantAnswer run_timed(const ContestantTask& task, const std::string& where) {
  constexpr double kNoTimeout = 1e8;
  if (!(task.timeout_s < kNoTimeout)) return run_moving_task(task, where);
  ContestantAnswer answer = run_contestant(task);
  if (answer.outcome == "bad_input") throw InputError(where + ": " + answer.message);
  if (answer.outcome == "unavailable")
    throw UnavailableError(task.method.method->name + ": " + answer.message);
  return answer;
}

}  // namespace

ProbeHistory read_probe_history(const fs::path& file) {
  const json answer = reference::read_json_file(file, {kLargestAnswer, kAnswerDepth});
  ProbeHistory history;
  try {
    std::vector<std::size_t> wanted;
    std::optional<std::size_t> time;
    const json& columns = answer.at("columns");
    for (std::size_t k = 0; k < columns.size(); ++k) {
      const std::string name = columns[k].get<std::string>();
      if (name == "time_s") time = k;
      if (name.rfind("probe_", 0) == 0) wanted.push_back(k);
    }
    if (!time || wanted.empty()) throw InputError(file.string(), 0, "time and probes", columns.dump());
    const auto number = [](const json& value) { return value.is_number() ? value.get<double>() : kNoNumber; };
    for (const json& row : answer.at("rows")) {
      history.time_s.push_back(number(row.at(*time)));
      std::vector<double>& cells = history.row.emplace_back();
      for (const std::size_t k : wanted) cells.push_back(number(row.at(k)));
    }
  } catch (const json::exception& error) {
    throw InputError(file.string() + ": rows and columns were expected: " + error.what());
  }
  return history;
}

double history_difference(const ProbeHistory& coarse, const ProbeHistory& fine) {
  double off = 0.0;
  double size = 0.0;
  std::size_t k = 0;
  for (std::size_t row = 0; row < coarse.time_s.size(); ++row) {
    const double time_s = coarse.time_s[row];
    while (k + 2 < fine.time_s.size() && fine.time_s[k + 1] < time_s) ++k;
    if (k + 1 >= fine.time_s.size() || time_s > fine.time_s[k + 1]) break;
    for (std::size_t c = 0; c < coarse.row[row].size(); ++c) {
      const double there = between(fine, k, c, time_s);
      off += (coarse.row[row][c] - there) * (coarse.row[row][c] - there);
      size += there * there;
    }
  }
  return relative_size(off, size);
}

json with_fixed_step(const json& scene, double step_s, const json& probes_m) {
  json out = scene;
  json& dynamic = out["analysis"]["dynamic"];
  dynamic["time_step_s"] = step_s;
  dynamic["allow_unstable"] = true;
  dynamic["frames"] = 0;
  dynamic["samples"] = 400;
  dynamic["probes_m"] = probes_m;
  dynamic.erase("safety");
  return out;
}

json spread_probes(std::span<const Vec3> points, std::size_t count) {
  json places = json::array();
  if (points.empty()) return places;
  std::vector<double> gap_sq(points.size(), std::numeric_limits<double>::infinity());
  std::size_t next = 0;
  while (places.size() < std::min(count, points.size())) {
    const Vec3 at = points[next];
    places.push_back({at.x, at.y, at.z});
    for (std::size_t v = 0; v < gap_sq.size(); ++v)
      gap_sq[v] = std::min(gap_sq[v], length_sq(points[v] - at));
    next = static_cast<std::size_t>(std::max_element(gap_sq.begin(), gap_sq.end()) - gap_sq.begin());
  }
  return places;
}

json choose_probes(const Scene& scene, const fs::path& fitted_mesh, std::size_t count) {
  if (!scene.require || scene.require->places.empty())
    return spread_probes(read_medit(fitted_mesh, ReadOrientation::kKeep).mesh.points, count);
  const TetMesh mesh = build_scene_mesh(scene.mesh).mesh;
  std::vector<Vec3> chosen;
  for (const std::size_t v : find_error_points(*place_scene(scene, mesh).require, mesh))
    chosen.push_back(mesh.points[v]);
  return spread_probes(chosen, count);
}

double difference_at_rows(const ProbeHistory& of, const ProbeHistory& truth) {
  if (of.time_s.size() < 2) return std::numeric_limits<double>::infinity();
  const double slack_s = kSameTime * truth.time_s.back();
  double off = 0.0;
  double size = 0.0;
  std::size_t k = 0;
  for (std::size_t row = 0; row < truth.time_s.size(); ++row) {
    const double time_s = truth.time_s[row];
    while (k + 2 < of.time_s.size() && of.time_s[k + 1] < time_s) ++k;
    if (time_s > of.time_s[k + 1] + slack_s || of.row[k].size() != truth.row[row].size())
      return std::numeric_limits<double>::infinity();
    for (std::size_t c = 0; c < truth.row[row].size(); ++c) {
      const double there = between(of, k, c, time_s);
      off += (there - truth.row[row][c]) * (there - truth.row[row][c]);
      size += truth.row[row][c] * truth.row[row][c];
    }
  }
  return relative_size(off, size);
}

PlacedTrial place_trial(const json& scene_json, const TrialSettings& settings) {
  create_folder(settings.folder);
  json placed = scene_json;
  const auto absolute = [](const fs::path& file) { return fs::absolute(file).lexically_normal().string(); };
  const std::string whole = placed.value("/mesh/regions_from"_json_pointer, "");
  placed["mesh"] = {{"file", absolute(settings.mesh)}, {"unit_m", 1}};
  if (!whole.empty()) placed["mesh"]["regions_from"] = absolute(settings.mesh.parent_path() / whole);
  for (const char* key : {"envelope", "require", "probes_m"}) placed.erase(key);
  if (placed["model"].contains("frozen"))  // beside the mesh, unless it says where
    placed["model"]["frozen"] =
        fs::absolute(settings.mesh.parent_path() / placed["model"]["frozen"].get<std::string>())
            .lexically_normal()
            .string();
  write_file_atomically(settings.folder / "scene.yaml", placed.dump(1) + "\n");
  const Scene scene = read_scene(settings.folder / "scene.yaml");
  TetMesh mesh = build_scene_mesh(scene.mesh).mesh;
  Scene on_mesh = place_scene(scene, mesh);
  return {std::move(on_mesh), std::move(mesh)};
}

MotionTrial run_motion_trial(const json& scene_json, const TrialSettings& settings,
                             const Registry& registry) {
  const PlacedTrial placed = place_trial(scene_json, settings);
  const reference::MovingBody body = build_moving_body(placed.scene, placed.mesh, registry);
  ContestantTask task = start_replay(body, placed.mesh, registry, settings.folder / "body");
  task.stop_flag = settings.stop_flag;
  task.options["stop_after_s"] = settings.timeout_s;
  const bool is_modal = body.model.method == reference::kModalModel;
  if (is_modal) {
    task.options["timings"] = settings.timings;
    task.timeout_s = settings.timeout_s + kSetupGraceS;  // modes are found to their end, or not at all
  }
  const ContestantAnswer answer = run_timed(task, placed.scene.analysis_where);
  MotionTrial trial;
  trial.outcome = answer.outcome == "ok" ? answer.report.value("outcome", "") : answer.outcome;
  trial.memory_bytes = answer.peak_rss_bytes.value_or(0);
  if (answer.report.is_object()) {
    trial.step_s = answer.report.value("time_step_s", 0.0);
    trial.kernel_s = answer.report.value("kernel_s", 0.0);
    trial.simulated_s = answer.report.value("simulated_s", 0.0);
    trial.setup_s = answer.report.value("setup_s", 0.0);
    const json force = answer.report.value("frozen_force_most_n", json());
    trial.frozen_force_n = force.is_number() ? force.get<double>() : 0.0;
    if (is_modal) {
      trial.pictures_s = kPicturesPerS * answer.report.at("field_s").get<double>();
      trial.again_s = answer.report.at("kernel_samples_s").get<std::vector<double>>();
    }
  }
  if (trial.outcome == "completed") trial.history = read_probe_history(answer.output);
  return trial;
}

}  // namespace palpate::experiments

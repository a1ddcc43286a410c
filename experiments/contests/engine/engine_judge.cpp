#include "experiments/contests/engine/engine_judge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/judge/displacement/reference_estimate.h"
#include "core/judge/mesh/exact_orientation.h"
#include "experiments/contests/engine/motion_returns.h"
#include "reference/door/json_file.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

constexpr const char* kSchema = "palpate/engine/1";
constexpr double kEndTolerance = 1e-6;  // of the duration: the last step may end beside it by a rounding

constexpr std::array kReported{"peak_speed_m_s",
                               "speeds_cut",
                               "inverted_tets_most",
                               "real_time_factor",
                               "tick_real_time_factor",
                               "stable_step_s",
                               "stability_margin",
                               "steps_per_tick",
                               "tick_p50_s",
                               "tick_p99_s",
                               "tick_p99_9_s",
                               "tick_worst_s",
                               "ticks",
                               "ticks_missed",
                               "setup_s",
                               "first_tick_s",
                               "residual_worst"};

/// One file; messages name it.
class EngineFile {
 public:
  EngineFile(const std::filesystem::path& path, const reference::MotionProblem& problem, const TetMesh& mesh)
      : where_(path.string()), problem_(problem), mesh_(mesh), root_(reference::read_json_file(path)) {
    if (!root_.is_object()) fail("an object", root_);
  }

  bool is_engine_file() const { return root_.value("schema", json()) == kSchema; }
  std::string kind() const { return need("kind").is_string() ? need("kind").get<std::string>() : ""; }

  void judge_replay(json& figures) const {
    const std::vector<MotionLevel> levels = read_levels(figures);
    const std::vector<MotionReturn> returns = find_returns(problem_, levels);
    figures["returns"] = returns_to_json(returns);
    add_worst_returns(figures);
    const json& frames = need("frames");
    if (!frames.is_array()) fail("a list of frames", frames);
    std::size_t most = 0;
    for (const json& frame : frames) most = std::max(most, count_inverted(frame));
    if (!frames.empty()) figures["inverted_in_frames_most"] = most;
  }

  void judge_rest(json& figures) const {
    const std::vector<std::vector<double>> rows = read_rows({"rate_per_s", "frequency_per_s"});
    double slowest = 0.0;  // of -1 / rate; infinite where one does not fall
    for (const std::vector<double>& row : rows)
      slowest = std::max(slowest, row[0] < 0.0 ? -1.0 / row[0] : std::numeric_limits<double>::infinity());
    if (slowest > 0.0 && std::isfinite(slowest)) figures["slowest_decay_s"] = slowest;
  }

  void judge_ticks(json& figures) const {
    const json& forces = need("held_forces_n");
    if (!forces.is_array() || forces.empty()) fail("forces of the last ticks", forces);
    std::vector<Vec3> held;
    for (const json& each : forces) {
      const std::vector<double> f = read_numbers(each, 3);
      held.push_back({f[0], f[1], f[2]});
    }
    Vec3 mean;
    for (const Vec3& f : held) mean = mean + (1.0 / static_cast<double>(held.size())) * f;
    double spread = 0.0;
    for (const Vec3& f : held) spread = std::max(spread, length(f - mean));
    figures["held_force_n"] = {mean.x, mean.y, mean.z};
    figures["held_force_size_n"] = length(mean);
    figures["held_force_spread_n"] = spread;
  }

 private:
  [[noreturn]] void fail(const std::string& expected, const json& found) const {
    throw InputError(where_, 0, expected, found.dump().substr(0, 80));
  }

  const json& need(const char* key) const {
    const auto at = root_.find(key);
    if (at == root_.end()) fail(std::string("the key \"") + key + "\"", "none");
    return *at;
  }

  std::vector<double> read_numbers(const json& list, std::size_t count) const {
    if (!list.is_array() || list.size() != count) fail(std::to_string(count) + " numbers", list);
    std::vector<double> out;
    for (const json& value : list) {
      if (!value.is_number()) fail("a number", value);
      out.push_back(value.get<double>());
    }
    return out;
  }

  std::size_t place_of(const char* column) const {
    const json& columns = need("columns");
    const auto at = std::find(columns.begin(), columns.end(), json(column));
    if (!columns.is_array() || at == columns.end())
      fail(std::string("the column \"") + column + "\"", columns);
    return static_cast<std::size_t>(at - columns.begin());
  }

  /// These columns of all rows, in this order.
  std::vector<std::vector<double>> read_rows(const std::vector<const char*>& columns) const {
    std::vector<std::size_t> places;
    places.reserve(columns.size());
    for (const char* column : columns) places.push_back(place_of(column));
    std::vector<std::vector<double>> out;
    const json& rows = need("rows");
    if (!rows.is_array()) fail("a list of rows", rows);
    for (const json& row : rows) {
      if (!row.is_array() || row.size() != need("columns").size()) fail("one cell a column", row);
      std::vector<double>& values = out.emplace_back();
      for (const std::size_t place : places) {
        if (!row[place].is_number()) fail("a number", row[place]);
        values.push_back(row[place].get<double>());
      }
    }
    return out;
  }

  std::vector<MotionLevel> read_levels(json& figures) const {
    std::vector<MotionLevel> levels;
    double fastest = 0.0;
    double farthest = 0.0;
    for (const std::vector<double>& row :
         read_rows({"time_s", "largest_displacement_m", "rms_displacement_m", "largest_speed_m_s"})) {
      if (levels.empty() ? row[0] != 0.0 : row[0] <= levels.back().time_s)
        fail("times that rise from 0", row[0]);
      levels.push_back({row[0], row[1], row[2]});
      farthest = std::max(farthest, row[1]);
      fastest = std::max(fastest, row[3]);
    }
    const double end = levels.empty() ? 0.0 : levels.back().time_s;
    if (end < problem_.duration_s * (1.0 - kEndTolerance))
      fail("rows to " + json(problem_.duration_s).dump() + " s", end);
    figures["largest_displacement_m"] = farthest;
    figures["largest_speed_in_rows_m_s"] = fastest;
    return levels;
  }

  /// The worst of the returns; a figure that one of them did not reach is left out.
  static void add_worst_returns(json& figures) {
    const json& returns = figures.at("returns");
    if (returns.empty()) return;
    for (const auto& [key, name] :
         {std::pair{"error", "return_error"}, std::pair{"rms_error", "return_rms_error"},
          std::pair{"half_s", "half_return_s"}, std::pair{"twentieth_s", "twentieth_return_s"}}) {
      double most = 0.0;
      bool is_whole = true;
      for (const json& each : returns) {
        is_whole = is_whole && each.at(key).is_number();
        if (is_whole) most = std::max(most, each.at(key).get<double>());
      }
      if (is_whole) figures[name] = most;
    }
  }

  std::size_t count_inverted(const json& frame) const {
    if (!frame.is_object() || !frame.contains("displacement_m")) fail("displacements of a frame", frame);
    const std::vector<double> u = read_numbers(frame.at("displacement_m"), 3 * mesh_.points.size());
    const auto moved = [&](Index v) {
      return mesh_.points[v] +
             Vec3{u[3 * std::size_t{v}], u[3 * std::size_t{v} + 1], u[3 * std::size_t{v} + 2]};
    };
    std::size_t inverted = 0;
    for (const Tet& tet : mesh_.tets) {
      if (judge::exact_orientation(moved(tet[0]), moved(tet[1]), moved(tet[2]), moved(tet[3])) < 0)
        ++inverted;
    }
    return inverted;
  }

  std::string where_;
  const reference::MotionProblem& problem_;
  const TetMesh& mesh_;
  json root_;
};

}  // namespace

json judge_engine_file(const reference::MotionProblem& problem, const TetMesh& mesh, const json& report,
                       const std::filesystem::path& file) {
  json figures = {{"kind", "engine"}, {"valid", true}, {"findings", json::array()}};
  const std::string outcome = report.at("outcome").get<std::string>();
  if (outcome != "completed") {
    figures["valid"] = false;
    figures["findings"].push_back("its outcome is " + outcome);
    return figures;
  }
  const EngineFile answer(file, problem, mesh);
  if (!answer.is_engine_file()) return figures;
  const std::string kind = answer.kind();
  figures["kind"] = kind;
  if (kind == "replay") {
    answer.judge_replay(figures);
  } else if (kind == "rest") {
    answer.judge_rest(figures);
  } else if (kind == "ticks") {
    answer.judge_ticks(figures);
  } else {
    throw InputError(file.string(), 0, "the kind replay, rest or ticks", "\"" + kind + "\"");
  }
  return figures;
}

json reported_figures(const json& report) {
  json figures = json::object();
  for (const char* name : kReported) {
    if (report.value(name, json()).is_number()) figures[name] = report.at(name);
  }
  return figures;
}

void compare_force(const ReferenceForce& reference, json& figures) {
  if (!figures.contains("held_force_n")) return;
  const auto held = figures.at("held_force_n").get<std::vector<double>>();
  const double size = length(reference.force_n);
  figures["reference_force_size_n"] = size;
  if (reference.change) figures["reference_force_change"] = *reference.change;
  if (!(size > 0.0)) return;
  const double error = length(Vec3{held.at(0), held.at(1), held.at(2)} - reference.force_n) / size;
  figures["force_error"] = error;
  figures["reference_too_coarse"] = judge::is_reference_too_coarse(error, reference.change);
}

}  // namespace palpate::experiments

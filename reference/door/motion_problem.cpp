#include "reference/door/motion_problem.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <set>
#include <sstream>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/base/plain_file.h"
#include "core/mesh/io/medit.h"
#include "core/mesh/subdivision/refinement.h"
#include "reference/door/deform_problem.h"
#include "reference/door/json_file.h"

namespace palpate::reference {
namespace {

using nlohmann::json;

constexpr const char* kMotionSchema = "palpate/motion_problem/1";
constexpr std::int64_t kMostSamples = 1'000'000'000;
constexpr std::int64_t kMostFrequencies = 1000;

/// Reads one problem; messages name the place below `where_`.
class MotionReader {
 public:
  MotionReader(const TetMesh& mesh, std::string where) : mesh_(mesh), where_(std::move(where)) {}

  MotionProblem read(const json& value) const {
    check_keys(value, "",
               {"schema", "body", "loads", "damping", "duration_s", "samples", "probes", "frequencies"});
    if (value.value("schema", json()) != kMotionSchema)
      fail("schema", kMotionSchema, value.value("schema", json()));
    MotionProblem problem;
    problem.body = problem_from_json(at(value, "body", ""), mesh_, where_ + ": body");
    const json& loads = at(value, "loads", "");
    if (!loads.is_array()) fail("loads", "a list", loads);
    for (std::size_t k = 0; k < loads.size(); ++k)
      problem.loads.push_back(read_load(loads[k], "loads[" + std::to_string(k) + "]", problem.body));
    const json damping = value.value("damping", json::object());
    check_keys(damping, "damping", {"stiffness_s", "mass_per_s"});
    problem.damping_stiffness_s =
        read_not_negative(damping.value("stiffness_s", json(0.0)), "damping.stiffness_s");
    problem.damping_mass_per_s =
        read_not_negative(damping.value("mass_per_s", json(0.0)), "damping.mass_per_s");
    problem.duration_s = read_not_negative(at(value, "duration_s", ""), "duration_s");
    if (problem.duration_s == 0.0) fail("duration_s", "a duration above 0", 0.0);
    problem.samples = static_cast<std::uint64_t>(
        read_whole(value.value("samples", json(1000)), "samples", 1, kMostSamples));
    problem.frequencies = static_cast<std::size_t>(
        read_whole(value.value("frequencies", json(0)), "frequencies", 0, kMostFrequencies));
    const json probes = value.value("probes", json::array());
    if (!probes.is_array()) fail("probes", "a list of vertices", probes);
    for (const json& probe : probes)
      problem.probes.push_back(static_cast<Index>(
          read_whole(probe, "probes", 0, static_cast<std::int64_t>(mesh_.points.size()) - 1)));
    return problem;
  }

 private:
  [[noreturn]] void fail(const std::string& key, const std::string& expected, const json& found) const {
    throw InputError(where_ + (key.empty() ? "" : ": " + key), 0, expected, found.dump().substr(0, 80));
  }

  const json& at(const json& object, const char* key, const std::string& inside) const {
    if (!object.contains(key)) fail(inside, std::string("the key \"") + key + "\"", json("none"));
    return object.at(key);
  }

  void check_keys(const json& object, const std::string& key, const std::set<std::string>& known) const {
    if (!object.is_object()) fail(key, "an object", object);
    for (const auto& [name, value] : object.items()) {
      if (known.count(name) == 0) fail(key, "no key \"" + name + "\"", value);
    }
  }

  double read_not_negative(const json& value, const std::string& key) const {
    if (!value.is_number() || !std::isfinite(value.get<double>()) || value.get<double>() < 0.0)
      fail(key, "a finite number from 0", value);
    return value.get<double>();
  }

  std::int64_t read_whole(const json& value, const std::string& key, std::int64_t low,
                          std::int64_t high) const {
    if (!value.is_number_integer() || value.get<std::int64_t>() < low || value.get<std::int64_t>() > high)
      fail(key, "a whole number from " + std::to_string(low) + " to " + std::to_string(high), value);
    return value.get<std::int64_t>();
  }

  dynamics::TimeProfile read_profile(const json& value, const std::string& key) const {
    check_keys(value, key, {"times_s", "shares", "smooth"});
    dynamics::TimeProfile profile;
    for (const auto& [name, numbers] :
         {std::pair{"times_s", &profile.time_s}, std::pair{"shares", &profile.share}}) {
      const json& list = at(value, name, key);
      if (!list.is_array()) fail(key + "." + name, "a list of numbers", list);
      numbers->clear();
      for (const json& item : list) {
        if (!item.is_number()) fail(key + "." + name, "a list of numbers", item);
        numbers->push_back(item.get<double>());
      }
    }
    const json smooth = value.value("smooth", json(false));
    if (!smooth.is_boolean()) fail(key + ".smooth", "true or false", smooth);
    profile.smooth = smooth.get<bool>();
    try {
      validate(profile);
    } catch (const InputError& error) {
      throw InputError(where_ + ": " + key + ": " + error.what());
    }
    return profile;
  }

  MotionLoad read_load(const json& value, const std::string& key, const BoundaryProblem& body) const {
    check_keys(value, key, {"part", "profile", "from_s", "until_s"});
    MotionLoad load;
    load.part = problem_from_json(at(value, "part", key), mesh_, where_ + ": " + key);
    const Material& material = load.part.material;
    if (material.young_modulus_pa != body.material.young_modulus_pa ||
        material.poisson_ratio != body.material.poisson_ratio ||
        material.density_kg_m3 != body.material.density_kg_m3 || load.part.strain != body.strain)
      fail(key + ".part", "the body's material and size of strain", json("others"));
    if (value.contains("profile")) load.profile = read_profile(value.at("profile"), key + ".profile");
    load.from_s = read_not_negative(value.value("from_s", json(0.0)), key + ".from_s");
    if (value.contains("until_s")) {
      load.until_s = read_not_negative(value.at("until_s"), key + ".until_s");
      if (*load.until_s <= load.from_s) fail(key + ".until_s", "a time after from_s", *load.until_s);
    }
    return load;
  }

  const TetMesh& mesh_;
  std::string where_;
};

json load_to_json(const MotionLoad& load) {
  json value = {
      {"part", problem_to_json(load.part)},
      {"profile",
       {{"times_s", load.profile.time_s}, {"shares", load.profile.share}, {"smooth", load.profile.smooth}}},
      {"from_s", load.from_s}};
  if (load.until_s) value["until_s"] = *load.until_s;
  return value;
}

/// The numbers of a line; empty unless there are `count` finite ones.
std::vector<double> read_numbers(const std::string& line, std::size_t count) {
  std::vector<double> numbers;
  const char* at = line.data();
  const char* const end = at + line.size();
  while (at <= end && numbers.size() < count) {
    double number = 0.0;
    const auto [next, error] = std::from_chars(at, end, number);
    if (error != std::errc{} || !std::isfinite(number)) return {};
    numbers.push_back(number);
    if (next == end) return numbers.size() == count ? numbers : std::vector<double>{};
    if (*next != ',') return {};
    at = next + 1;
  }
  return {};
}

std::string joined_columns(const std::vector<std::string>& columns) {
  std::string text;
  for (const std::string& name : columns) text += (text.empty() ? "" : ",") + name;
  return text;
}

}  // namespace

json motion_to_json(const MotionProblem& problem) {
  json value = {
      {"schema", kMotionSchema},
      {"body", problem_to_json(problem.body)},
      {"loads", json::array()},
      {"damping", {{"stiffness_s", problem.damping_stiffness_s}, {"mass_per_s", problem.damping_mass_per_s}}},
      {"duration_s", problem.duration_s},
      {"samples", problem.samples},
      {"probes", problem.probes},
      {"frequencies", problem.frequencies}};
  for (const MotionLoad& load : problem.loads) value["loads"].push_back(load_to_json(load));
  return value;
}

MotionProblem motion_from_json(const json& value, const TetMesh& mesh, const std::string& where) {
  return MotionReader(mesh, where).read(value);
}

MotionTask read_motion_task(const Request& request) {
  if (request.contest != "motion") throw InputError("contest", 0, "motion", request.contest);
  MotionTask task;
  task.mesh = read_medit(request.input, ReadOrientation::kKeep).mesh;
  task.problem = motion_from_json(read_json_file(request.problem), task.mesh, request.problem.string());
  return task;
}

MotionProblem refine_motion(const MotionProblem& problem, const TetMesh& mesh, const TetMesh& refined) {
  MotionProblem made = problem;
  made.body = refine_problem(problem.body, mesh, refined);
  for (MotionLoad& load : made.loads) load.part = refine_problem(load.part, mesh, refined);
  return made;
}

std::vector<LoadPhase> find_phases(const MotionProblem& problem) {
  std::set<double> times{0.0, problem.duration_s};
  for (const MotionLoad& load : problem.loads) {
    for (const double time : {load.from_s, load.until_s.value_or(0.0)}) {
      if (time < problem.duration_s) times.insert(time);
    }
  }
  std::vector<LoadPhase> phases;
  for (auto from = times.begin(); std::next(from) != times.end(); ++from) {
    LoadPhase phase{*from, *std::next(from), {}};
    const double middle = 0.5 * (phase.from_s + phase.to_s);
    for (std::size_t k = 0; k < problem.loads.size(); ++k) {
      const MotionLoad& load = problem.loads[k];
      if (load.from_s <= middle && load.until_s.value_or(middle) >= middle) phase.loads.push_back(k);
    }
    phases.push_back(std::move(phase));
  }
  return phases;
}

std::vector<std::string> history_columns(const MotionProblem& problem) {
  std::vector<std::string> columns{"time_s", "kinetic_j", "elastic_j", "load_j", "total_j"};
  for (std::size_t k = 0; k < problem.loads.size(); ++k) {
    if (!problem.loads[k].is_tool()) continue;
    for (const char* axis : {"x", "y", "z"})
      columns.push_back("tool_" + std::to_string(k + 1) + "_f" + axis + "_n");
  }
  for (std::size_t k = 0; k < problem.probes.size(); ++k) {
    for (const char* axis : {"x", "y", "z"})
      columns.push_back("probe_" + std::to_string(k + 1) + "_u" + axis + "_m");
  }
  return columns;
}

std::vector<double> history_row(const MotionProblem& problem, const LoadPhase& phase,
                                const HistoryMoment& moment) {
  require(moment.push_n.size() == phase.loads.size() + 1 && moment.probe_m.size() == problem.probes.size(),
          "one force a load and one displacement a probe");
  std::vector<double> row{moment.time_s, moment.kinetic_j, moment.elastic_j, moment.load_j,
                          moment.kinetic_j + moment.elastic_j + moment.load_j};
  for (std::size_t k = 0; k < problem.loads.size(); ++k) {
    if (!problem.loads[k].is_tool()) continue;
    const auto at = std::find(phase.loads.begin(), phase.loads.end(), k);
    const Vec3 push = at == phase.loads.end()
                          ? Vec3{}
                          : moment.push_n[static_cast<std::size_t>(at - phase.loads.begin()) + 1];
    row.insert(row.end(), {push.x, push.y, push.z});
  }
  for (const Vec3& u : moment.probe_m) row.insert(row.end(), {u.x, u.y, u.z});
  return row;
}

void write_history(const std::filesystem::path& path, const MotionHistory& history) {
  std::string text = joined_columns(history.columns) + "\n";
  for (const std::vector<double>& row : history.rows) {
    require(row.size() == history.columns.size(), "one number a column");
    for (std::size_t k = 0; k < row.size(); ++k) {
      require(std::isfinite(row[k]), "a history that is written is finite");
      if (k > 0) text += ',';
      append_number(text, row[k]);
    }
    text += '\n';
  }
  write_file_atomically(path, text);
}

MotionHistory read_history(const std::filesystem::path& path, const MotionProblem& problem) {
  constexpr double kEndTolerance = 1e-9;
  refuse_no_file(path, "a history");
  std::ifstream file(path);
  const std::string where = path.string();
  MotionHistory history{history_columns(problem), {}};
  std::string line;
  if (!file || !std::getline(file, line)) throw InputError(where, 0, "a history", "none");
  if (line != joined_columns(history.columns))
    throw InputError(where, 1, joined_columns(history.columns), line.substr(0, 80));
  while (std::getline(file, line)) {
    std::vector<double> row = read_numbers(line, history.columns.size());
    const bool rises =
        !row.empty() && (history.rows.empty() ? row[0] == 0.0 : row[0] > history.rows.back()[0]);
    if (!rises)
      throw InputError(where, history.rows.size() + 2,
                       std::to_string(history.columns.size()) + " finite numbers, times rising from 0",
                       line.substr(0, 80));
    history.rows.push_back(std::move(row));
  }
  const double end = history.rows.empty() ? 0.0 : history.rows.back()[0];
  if (std::fabs(end - problem.duration_s) > kEndTolerance * problem.duration_s)
    throw InputError(where, 0, "a history to " + json(problem.duration_s).dump() + " s",
                     "its end at " + json(end).dump() + " s");
  return history;
}

MotionStates::MotionStates(double duration_s, std::size_t vertices)
    : duration_s_(duration_s),
      vertices_(vertices),
      most_(std::min(kMostStates, kMostNumbers / (3 * std::max<std::size_t>(1, vertices)))) {}

bool MotionStates::is_due(double time_s) const {
  if (most_ < 2) return false;
  const double between_s = duration_s_ / static_cast<double>(most_ - 1);
  const double next_s = between_s * static_cast<double>(states_.size());
  return states_.size() < most_ && time_s >= next_s * (1.0 - 1e-9);
}

void MotionStates::add(double time_s, std::vector<Vec3> displacement_m) {
  require(displacement_m.size() == vertices_, "one displacement a vertex");
  states_.push_back({time_s, std::move(displacement_m)});
}

void MotionStates::write_beside(const std::filesystem::path& history) const {
  if (states_.size() < 2) return;
  nlohmann::json written{{"schema", "palpate/states/1"}, {"states", nlohmann::json::array()}};
  for (const State& state : states_) {
    nlohmann::json field = nlohmann::json::array();
    for (const Vec3& u : state.displacement_m) {
      if (!is_finite(u)) return;
      for (const double x : {u.x, u.y, u.z}) field.push_back(std::round(1e9 * x) / 1e9);
    }
    written["states"].push_back({{"time_s", state.time_s}, {"displacement_m", std::move(field)}});
  }
  write_file_atomically(history.parent_path() / "states.json", written.dump() + "\n");
}

}  // namespace palpate::reference

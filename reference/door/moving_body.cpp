#include "reference/door/moving_body.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "core/base/error.h"
#include "core/mesh/io/medit.h"
#include "reference/door/json_file.h"

namespace palpate::reference {
namespace {

using nlohmann::json;

constexpr const char* kBodySchema = "palpate/moving_body/1";
constexpr std::uint64_t kMostFrames = 1'000'000'000;
constexpr std::uint64_t kMostIterations = 100'000;
constexpr std::uint64_t kMostSubsteps = 10'000;
constexpr std::array<const char*, 4> kEngines{"auto", "general", "plain",
                                              "tets"};  // in the order of EngineChoice

/// The members of one object, each of a known name; messages name the place.
class Members {
 public:
  Members(const json& object, std::string where, const std::set<std::string>& known)
      : object_(object), where_(std::move(where)) {
    if (!object.is_object()) fail("", "an object", object);
    for (const auto& [name, value] : object.items()) {
      if (known.count(name) == 0) fail("", "no key \"" + name + "\"", value);
    }
  }

  [[noreturn]] void fail(const std::string& key, const std::string& expected, const json& found) const {
    throw InputError(where_ + (key.empty() ? "" : "." + key), 0, expected, found.dump().substr(0, 80));
  }

  const json* find(const char* key) const {
    const auto at = object_.find(key);
    return at == object_.end() ? nullptr : &*at;
  }

  const json& need(const char* key) const {
    const json* found = find(key);
    if (found == nullptr) fail("", std::string("the key \"") + key + "\"", "none");
    return *found;
  }

  std::string text(const char* key) const {
    const json& value = need(key);
    if (!value.is_string()) fail(key, "a text", value);
    return value.get<std::string>();
  }

  bool flag(const char* key) const {
    const json& value = need(key);
    if (!value.is_boolean()) fail(key, "true or false", value);
    return value.get<bool>();
  }

  /// A finite number above zero, or from zero on.
  double number(const char* key, bool from_zero) const {
    const json& value = need(key);
    const double number = value.is_number() ? value.get<double>() : std::nan("");
    if (!std::isfinite(number) || number < 0.0 || (number == 0.0 && !from_zero))
      fail(key, from_zero ? "a finite number from 0" : "a finite number above 0", value);
    return number;
  }

  /// A whole number from 1 to `most`, or `otherwise`.
  std::size_t count(const char* key, std::uint64_t most, std::size_t otherwise) const {
    const json* value = find(key);
    if (value == nullptr) return otherwise;
    if (!value->is_number_unsigned() || *value == 0U || *value > most)
      fail(key, "a whole number from 1 to " + std::to_string(most), *value);
    return value->get<std::size_t>();
  }

  std::optional<double> number_if_there(const char* key) const {
    if (find(key) == nullptr) return std::nullopt;
    return number(key, false);
  }

  /// Calls `parse`, which throws for what it does not know.
  template <typename Parse>
  auto parsed(const char* key, const Parse& parse) const {
    const std::string name = text(key);
    try {
      return parse(name);
    } catch (const InputError& error) {
      throw InputError(where_ + "." + key + ": " + error.what());
    }
  }

 private:
  const json& object_;
  std::string where_;
};

MovingModel read_model(const json& value, const std::string& where) {
  const Members members(value, where, {"method", "options", "volume_force_of_n_per_m", "is_material"});
  MovingModel model;
  model.method = members.text("method");
  if (!model.method.starts_with("springs.") && !model.method.starts_with("smoothed.") &&
      model.method != kModalModel)
    members.fail("method", std::string("springs.NAME, smoothed.NAME or ") + kModalModel, model.method);
  model.options = members.need("options");
  if (!model.options.is_object()) members.fail("options", "an object", model.options);
  model.volume_force_of_n_per_m = members.number_if_there("volume_force_of_n_per_m");
  model.is_material = members.flag("is_material");
  return model;
}

MotionStepping read_stepping(const json& value, const std::string& where) {
  const Members members(
      value, where,
      {"integrator", "time_step_s", "safety", "engine", "precision", "allow_unstable", "speed_limit_m_s",
       "frames", "mass_per_vertex_kg", "damping_spring_n_s_per_m", "damping_vertex_n_s_per_m",
       "spring_damping", "iterations", "tolerance", "substeps"});
  MotionStepping out;
  out.is_exponential = members.text("integrator") == kExponential;
  if (!out.is_exponential) out.integrator = members.parsed("integrator", dynamics::parse_integrator);
  out.time_step_s = members.number_if_there("time_step_s");
  out.safety = members.number("safety", false);
  if (out.safety > 1.0) members.fail("safety", "at most 1", out.safety);
  const std::string engine = members.text("engine");
  const auto choice = std::find(kEngines.begin(), kEngines.end(), engine);
  if (choice == kEngines.end()) members.fail("engine", "auto, general, plain or tets", engine);
  out.engine = static_cast<EngineChoice>(choice - kEngines.begin());
  const std::string precision = members.text("precision");
  if (precision != "single" && precision != "double")
    members.fail("precision", "single or double", precision);
  out.single_precision = precision == "single";
  out.allow_unstable = members.flag("allow_unstable");
  out.speed_limit_m_s = members.number_if_there("speed_limit_m_s");
  const json& frames = members.need("frames");
  if (!frames.is_number_unsigned() || frames.get<std::uint64_t>() > kMostFrames)
    members.fail("frames", "a whole number from 0 to 1e9", frames);
  out.frames = frames.get<std::uint64_t>();
  out.mass_per_vertex_kg = members.number_if_there("mass_per_vertex_kg");
  out.damping_spring_n_s_per_m = members.number("damping_spring_n_s_per_m", true);
  out.damping_vertex_n_s_per_m = members.number("damping_vertex_n_s_per_m", true);
  out.spring_damping = members.parsed("spring_damping", dynamics::parse_spring_damping);
  out.solver.iterations = members.count("iterations", kMostIterations, out.solver.iterations);
  if (members.find("tolerance") != nullptr) out.solver.tolerance = members.number("tolerance", true);
  if (out.solver.tolerance > 1.0) members.fail("tolerance", "at most 1", out.solver.tolerance);
  out.substeps = members.count("substeps", kMostSubsteps, out.substeps);
  return out;
}

void put(const char* key, const std::optional<double>& value, json& into) {
  if (value) into[key] = *value;
}

}  // namespace

const char* engine_name(EngineChoice engine) {
  return kEngines.at(static_cast<std::size_t>(engine));
}

json moving_body_to_json(const MovingBody& body) {
  const MotionStepping& stepping = body.stepping;
  json model = {{"method", body.model.method},
                {"options", body.model.options},
                {"is_material", body.model.is_material}};
  put("volume_force_of_n_per_m", body.model.volume_force_of_n_per_m, model);
  json steps = {
      {"integrator", stepping.is_exponential ? kExponential : dynamics::integrator_name(stepping.integrator)},
      {"safety", stepping.safety},
      {"engine", engine_name(stepping.engine)},
      {"precision", stepping.single_precision ? "single" : "double"},
      {"allow_unstable", stepping.allow_unstable},
      {"frames", stepping.frames},
      {"damping_spring_n_s_per_m", stepping.damping_spring_n_s_per_m},
      {"damping_vertex_n_s_per_m", stepping.damping_vertex_n_s_per_m},
      {"spring_damping", dynamics::spring_damping_name(stepping.spring_damping)},
      {"iterations", stepping.solver.iterations},
      {"tolerance", stepping.solver.tolerance},
      {"substeps", stepping.substeps}};
  put("time_step_s", stepping.time_step_s, steps);
  put("speed_limit_m_s", stepping.speed_limit_m_s, steps);
  put("mass_per_vertex_kg", stepping.mass_per_vertex_kg, steps);
  return {{"schema", kBodySchema},
          {"motion", motion_to_json(body.motion)},
          {"model", model},
          {"stepping", steps}};
}

MovingBody moving_body_from_json(const json& value, const TetMesh& mesh, const std::string& where) {
  const Members members(value, where, {"schema", "motion", "model", "stepping"});
  if (members.text("schema") != kBodySchema) members.fail("schema", kBodySchema, members.need("schema"));
  return {motion_from_json(members.need("motion"), mesh, where + ": motion"),
          read_model(members.need("model"), where + ": model"),
          read_stepping(members.need("stepping"), where + ": stepping")};
}

MovingTask read_moving_task(const Request& request) {
  if (request.contest != "engine") throw InputError("contest", 0, "engine", "\"" + request.contest + "\"");
  MovingTask task;
  task.mesh = read_medit(request.input).mesh;
  task.body = moving_body_from_json(read_json_file(request.problem), task.mesh, request.problem.string());
  return task;
}

}  // namespace palpate::reference

#include "reference/door/stability_problem.h"

#include <array>
#include <cmath>
#include <set>

#include "core/base/error.h"
#include "core/mesh/io/medit.h"
#include "reference/door/json_file.h"

namespace palpate::reference {
namespace {

using nlohmann::json;

constexpr const char* kStabilitySchema = "palpate/stability_problem/1";
constexpr std::array<const char*, 6> kLaws{"none", "stiffness", "mass", "axial", "isotropic", "drag"};

/// Reads one problem; `where` names the file in messages.
struct Reader {
  const TetMesh& mesh;
  const std::string& where;

  [[noreturn]] void fail(const std::string& key, const std::string& expected, const json& found) const {
    throw InputError(where + ": " + key, 0, expected, found.dump().substr(0, 80));
  }

  /// An object with these keys and no others.
  const json& object(const json& value, const std::string& key, const std::set<std::string>& keys) const {
    if (!value.is_object()) fail(key, "an object", value);
    for (const auto& [name, each] : value.items()) {
      if (keys.count(name) == 0) fail(key, "no key \"" + name + "\"", each);
    }
    for (const std::string& name : keys) {
      if (!value.contains(name)) fail(key, "the key \"" + name + "\"", json("none"));
    }
    return value;
  }

  double number(const json& value, const std::string& key) const {
    if (!value.is_number() || !std::isfinite(value.get<double>())) fail(key, "a finite number", value);
    return value.get<double>();
  }

  double positive(const json& value, const std::string& key) const {
    if (!(number(value, key) > 0.0)) fail(key, "a number above zero", value);
    return value.get<double>();
  }

  double not_negative(const json& value, const std::string& key) const {
    if (!(number(value, key) >= 0.0)) fail(key, "a number of at least 0", value);
    return value.get<double>();
  }

  std::uint64_t whole(const json& value, const std::string& key) const {
    if (!value.is_number_integer() || value.get<std::int64_t>() < 0)
      fail(key, "a whole number from 0", value);
    return value.get<std::uint64_t>();
  }

  /// A list with one entry a vertex.
  const json& each_vertex(const json& value, const std::string& key) const {
    if (!value.is_array() || value.size() != mesh.points.size())
      fail(key, "a list of " + std::to_string(mesh.points.size()), value);
    return value;
  }

  Vec3 vector(const json& value, const std::string& key) const {
    if (!value.is_array() || value.size() != 3) fail(key, "three numbers", value);
    return {number(value[0], key), number(value[1], key), number(value[2], key)};
  }

  Material material(const json& value) const {
    object(value, "material", {"young_modulus_pa", "poisson_ratio", "density_kg_m3"});
    Material out;
    out.young_modulus_pa = positive(value.at("young_modulus_pa"), "material.young_modulus_pa");
    out.poisson_ratio = number(value.at("poisson_ratio"), "material.poisson_ratio");
    out.density_kg_m3 = positive(value.at("density_kg_m3"), "material.density_kg_m3");
    if (!(out.poisson_ratio > -1.0) || !(out.poisson_ratio < 0.5))
      fail("material.poisson_ratio", "a number between -1 and 0.5", value.at("poisson_ratio"));
    return out;
  }

  DampingLaw law(const json& value) const {
    for (std::size_t k = 0; k < kLaws.size(); ++k) {
      if (value == kLaws.at(k)) return static_cast<DampingLaw>(k);
    }
    fail("damping.law", "none, stiffness, mass, axial, isotropic or drag", value);
  }

  std::vector<Index> held(const json& value) const {
    if (!value.is_array()) fail("held", "a list of vertices", value);
    std::vector<Index> out;
    for (const json& vertex : value) {
      const std::uint64_t v = whole(vertex, "held");
      if (v >= mesh.points.size() || (!out.empty() && v <= out.back()))
        fail("held", "vertices below " + std::to_string(mesh.points.size()) + " that rise", vertex);
      out.push_back(static_cast<Index>(v));
    }
    return out;
  }
};

}  // namespace

json stability_to_json(const StabilityProblem& problem) {
  json start = json::array();
  for (const Vec3& u : problem.start_m) start.push_back({u.x, u.y, u.z});
  return {{"schema", kStabilitySchema},
          {"material",
           {{"young_modulus_pa", problem.material.young_modulus_pa},
            {"poisson_ratio", problem.material.poisson_ratio},
            {"density_kg_m3", problem.material.density_kg_m3}}},
          {"stiffness_factor", problem.stiffness_factor},
          {"mass_factors", problem.mass_factors},
          {"damping",
           {{"law", kLaws.at(static_cast<std::size_t>(problem.damping))}, {"ratio", problem.damping_ratio}}},
          {"held", problem.held},
          {"start_m", std::move(start)},
          {"seed", problem.seed}};
}

StabilityProblem stability_from_json(const json& value, const TetMesh& mesh, const std::string& where) {
  const Reader read{mesh, where};
  read.object(
      value, "problem",
      {"schema", "material", "stiffness_factor", "mass_factors", "damping", "held", "start_m", "seed"});
  if (value.at("schema") != kStabilitySchema) read.fail("schema", kStabilitySchema, value.at("schema"));
  StabilityProblem out;
  out.material = read.material(value.at("material"));
  out.stiffness_factor = read.not_negative(value.at("stiffness_factor"), "stiffness_factor");
  for (const json& factor : read.each_vertex(value.at("mass_factors"), "mass_factors"))
    out.mass_factors.push_back(read.positive(factor, "mass_factors"));
  const json& damping = read.object(value.at("damping"), "damping", {"law", "ratio"});
  out.damping = read.law(damping.at("law"));
  out.damping_ratio = read.not_negative(damping.at("ratio"), "damping.ratio");
  out.held = read.held(value.at("held"));
  for (const json& start : read.each_vertex(value.at("start_m"), "start_m"))
    out.start_m.push_back(read.vector(start, "start_m"));
  for (const Index v : out.held) {
    if (!(out.start_m[v] == Vec3{}))
      read.fail("start_m", "zeros where the body is held", value.at("start_m")[v]);
  }
  out.seed = read.whole(value.at("seed"), "seed");
  return out;
}

StabilityTask read_stability_task(const Request& request) {
  if (request.contest != "stability") throw InputError("contest", 0, "stability", request.contest);
  StabilityTask task;
  task.mesh = read_medit(request.input, ReadOrientation::kKeep).mesh;
  task.problem = stability_from_json(read_json_file(request.problem), task.mesh, request.problem.string());
  return task;
}

}  // namespace palpate::reference

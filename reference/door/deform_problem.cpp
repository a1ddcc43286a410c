#include "reference/door/deform_problem.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <set>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/base/plain_file.h"
#include "core/mesh/io/medit.h"
#include "core/mesh/topology.h"
#include "reference/door/json_file.h"

namespace palpate::reference {
namespace {

using nlohmann::json;

constexpr const char* kProblemSchema = "palpate/problem/1";
constexpr const char* kHeader = "vertex,ux_m,uy_m,uz_m";

json vector_to_json(const Vec3& value) {
  return {value.x, value.y, value.z};
}

/// Reads one problem; `where_` grows with the place that is read.
class ProblemReader {
 public:
  ProblemReader(const TetMesh& mesh, std::string where) : mesh_(mesh), where_(std::move(where)) {
    for (const Triangle& face : build_boundary(mesh)) boundary_.insert(from_least(face));
  }

  BoundaryProblem read(const json& value) const {
    check_keys(value, "",
               {"schema", "strain", "material", "gravity_m_s2", "held", "supports", "tractions",
                "nodal_forces", "body_force_n_m3", "held_field_m"});
    if (value.value("schema", json()) != kProblemSchema)
      fail("schema", kProblemSchema, value.value("schema", json()));
    BoundaryProblem problem;
    problem.material = read_material(at(value, "material"));
    const json strain = value.value("strain", json("small"));
    if (strain != "small" && strain != "large") fail("strain", "small or large", strain);
    problem.strain = strain == "small" ? StrainSize::kSmall : StrainSize::kLarge;
    problem.gravity_m_s2 = read_vector(value, "gravity_m_s2");
    each(value, "held", [&](const json& item, const std::string& key) {
      check_keys(item, key, {"faces", "axes", "by_m"});
      problem.held.push_back({read_faces(item, key), read_axes(item, key), read_vector(item, "by_m", key)});
    });
    each(value, "supports", [&](const json& item, const std::string& key) {
      check_keys(item, key, {"faces", "weight", "stiffness_pa_per_m", "by_m"});
      const double stiffness = read_number(at(item, "stiffness_pa_per_m", key), key + ".stiffness_pa_per_m");
      if (stiffness <= 0.0) fail(key + ".stiffness_pa_per_m", "a stiffness above 0", stiffness);
      problem.supports.push_back({read_patch(item, key), stiffness, read_vector(item, "by_m", key)});
    });
    each(value, "tractions", [&](const json& item, const std::string& key) {
      check_keys(item, key, {"faces", "weight", "traction_pa", "pressure_pa"});
      problem.tractions.push_back({read_patch(item, key), read_vector(item, "traction_pa", key),
                                   read_number(item.value("pressure_pa", json(0.0)), key + ".pressure_pa")});
    });
    each(value, "nodal_forces", [&](const json& item, const std::string& key) {
      check_keys(item, key, {"vertex", "force_n"});
      problem.nodal_forces.push_back(
          {read_index(at(item, "vertex", key), key + ".vertex"), read_vector(item, "force_n", key)});
    });
    check_agreement(problem.held);
    problem.body_force_n_m3 = read_field(value, "body_force_n_m3");
    problem.held_field_m = read_field(value, "held_field_m");
    return problem;
  }

 private:
  [[noreturn]] void fail(const std::string& key, const std::string& expected, const json& found) const {
    throw InputError(where_ + (key.empty() ? "" : ": " + key), 0, expected, found.dump().substr(0, 80));
  }

  static Triangle from_least(Triangle face) {
    std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
    return face;
  }

  const json& at(const json& object, const char* key, const std::string& inside = "") const {
    if (!object.contains(key)) fail(inside, std::string("the key \"") + key + "\"", json("none"));
    return object.at(key);
  }

  void check_keys(const json& object, const std::string& key, const std::set<std::string>& known) const {
    if (!object.is_object()) fail(key, "an object", object);
    for (const auto& [name, value] : object.items()) {
      if (known.count(name) == 0) fail(key, "no key \"" + name + "\"", value);
    }
  }

  void each(const json& object, const char* key,
            const std::function<void(const json&, const std::string&)>& read_item) const {
    if (!object.contains(key)) return;
    const json& list = object.at(key);
    if (!list.is_array()) fail(key, "a list", list);
    for (std::size_t i = 0; i < list.size(); ++i)
      read_item(list[i], std::string(key) + "[" + std::to_string(i) + "]");
  }

  double read_number(const json& value, const std::string& key) const {
    if (!value.is_number() || !std::isfinite(value.get<double>())) fail(key, "a finite number", value);
    return value.get<double>();
  }

  Index read_index(const json& value, const std::string& key) const {
    const bool fits = value.is_number_integer() && value.get<std::int64_t>() >= 0 &&
                      value.get<std::uint64_t>() < mesh_.points.size();
    if (!fits) fail(key, "a vertex below " + std::to_string(mesh_.points.size()), value);
    return value.get<Index>();
  }

  Vec3 read_vector(const json& object, const char* name, const std::string& inside = "") const {
    if (!object.contains(name)) return {};
    return to_vector(object.at(name), inside.empty() ? name : inside + "." + name);
  }

  Vec3 to_vector(const json& value, const std::string& key) const {
    if (!value.is_array() || value.size() != 3) fail(key, "three numbers", value);
    return {read_number(value[0], key), read_number(value[1], key), read_number(value[2], key)};
  }

  /// A value at each vertex and edge midpoint; empty if the key is not there.
  std::vector<Vec3> read_field(const json& object, const char* key) const {
    if (!object.contains(key)) return {};
    const json& list = object.at(key);
    const std::size_t nodes = mesh_.points.size() + build_edges(mesh_).size();
    if (!list.is_array() || list.size() != nodes) {
      fail(key, "a value a vertex and a value an edge midpoint (" + std::to_string(nodes) + ")",
           list.is_array() ? json(list.size()) : list);
    }
    std::vector<Vec3> field;
    field.reserve(nodes);
    for (std::size_t i = 0; i < nodes; ++i) {
      field.push_back(to_vector(list[i], std::string(key) + "[" + std::to_string(i) + "]"));
    }
    return field;
  }

  std::array<bool, 3> read_axes(const json& object, const std::string& key) const {
    const json value = object.value("axes", json({true, true, true}));
    const bool fits =
        value.is_array() && value.size() == 3 &&
        std::all_of(value.begin(), value.end(), [](const json& axis) { return axis.is_boolean(); });
    if (!fits) fail(key + ".axes", "three of true and false", value);
    return {value[0].get<bool>(), value[1].get<bool>(), value[2].get<bool>()};
  }

  std::vector<Triangle> read_faces(const json& object, const std::string& inside) const {
    const std::string key = inside + ".faces";
    const json& list = at(object, "faces", inside);
    if (!list.is_array() || list.empty()) fail(key, "at least one face", list);
    std::vector<Triangle> faces;
    std::set<Triangle> seen;
    for (const json& item : list) {
      if (!item.is_array() || item.size() != 3) fail(key, "three vertices a face", item);
      const Triangle face{read_index(item[0], key), read_index(item[1], key), read_index(item[2], key)};
      if (boundary_.count(from_least(face)) == 0) {
        fail(key, "faces of the boundary, counter-clockwise seen from outside", item);
      }
      if (!seen.insert(from_least(face)).second) fail(key, "each face once", item);
      faces.push_back(face);
    }
    return faces;
  }

  FacePatch read_patch(const json& object, const std::string& key) const {
    FacePatch patch;
    patch.faces = read_faces(object, key);
    const json& weights = at(object, "weight", key);
    if (!weights.is_array() || weights.size() != patch.faces.size()) {
      fail(key + ".weight", "one weight a face (" + std::to_string(patch.faces.size()) + ")",
           weights.is_array() ? json(weights.size()) : weights);
    }
    for (const json& item : weights) {
      const double weight = read_number(item, key + ".weight");
      if (weight <= 0.0 || weight > 1.0) fail(key + ".weight", "weights above 0 and at most 1", item);
      patch.weight.push_back(weight);
    }
    return patch;
  }

  Material read_material(const json& value) const {
    check_keys(value, "material", {"young_modulus_pa", "poisson_ratio", "density_kg_m3"});
    Material material;
    const auto number = [&](const char* key) {
      return read_number(at(value, key, "material"), std::string("material.") + key);
    };
    material.young_modulus_pa = number("young_modulus_pa");
    material.poisson_ratio = number("poisson_ratio");
    material.density_kg_m3 = number("density_kg_m3");
    if (material.young_modulus_pa <= 0.0) {
      fail("material.young_modulus_pa", "a modulus above 0", material.young_modulus_pa);
    }
    if (material.poisson_ratio <= -1.0 || material.poisson_ratio >= 0.5) {
      fail("material.poisson_ratio", "a ratio above -1 and below 0.5", material.poisson_ratio);
    }
    if (material.density_kg_m3 <= 0.0) {
      fail("material.density_kg_m3", "a density above 0", material.density_kg_m3);
    }
    return material;
  }

  /// A vertex of two held patches must be told the same by both, axis by axis.
  void check_agreement(const std::vector<HeldFaces>& held) const {
    std::map<std::pair<Index, int>, double> told;
    for (const HeldFaces& patch : held) {
      const std::array<double, 3> by{patch.by_m.x, patch.by_m.y, patch.by_m.z};
      for (const Triangle& face : patch.faces) {
        for (const Index vertex : face) {
          for (int axis = 0; axis < 3; ++axis) {
            const auto k = static_cast<std::size_t>(axis);
            if (!patch.axes[k]) continue;
            const double first = told.emplace(std::pair{vertex, axis}, by[k]).first->second;
            if (first != by[k]) {
              fail("held",
                   "one displacement for vertex " + std::to_string(vertex) + " along axis " +
                       std::to_string(axis) + " (" + json(first).dump() + " m)",
                   by[k]);
            }
          }
        }
      }
    }
  }

  const TetMesh& mesh_;
  std::string where_;
  std::set<Triangle> boundary_;
};

json patch_to_json(const FacePatch& patch) {
  return {{"faces", patch.faces}, {"weight", patch.weight}};
}

/// The number at `text`; moves `text` behind it and the comma or the end that follows. False if there is
/// none.
template <typename Number>
bool take_number(std::string_view& text, Number& value, bool is_last) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{}) return false;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  if (is_last) return text.empty();
  if (text.empty() || text.front() != ',') return false;
  text.remove_prefix(1);
  return true;
}

}  // namespace

json problem_to_json(const BoundaryProblem& problem) {
  json value = {{"schema", kProblemSchema},
                {"strain", problem.strain == StrainSize::kSmall ? "small" : "large"},
                {"material",
                 {{"young_modulus_pa", problem.material.young_modulus_pa},
                  {"poisson_ratio", problem.material.poisson_ratio},
                  {"density_kg_m3", problem.material.density_kg_m3}}},
                {"gravity_m_s2", vector_to_json(problem.gravity_m_s2)},
                {"held", json::array()},
                {"supports", json::array()},
                {"tractions", json::array()},
                {"nodal_forces", json::array()}};
  for (const HeldFaces& held : problem.held) {
    value["held"].push_back(
        {{"faces", held.faces}, {"axes", held.axes}, {"by_m", vector_to_json(held.by_m)}});
  }
  for (const ElasticSupport& support : problem.supports) {
    json item = patch_to_json(support.patch);
    item["stiffness_pa_per_m"] = support.stiffness_pa_per_m;
    item["by_m"] = vector_to_json(support.by_m);
    value["supports"].push_back(std::move(item));
  }
  for (const Traction& traction : problem.tractions) {
    json item = patch_to_json(traction.patch);
    item["traction_pa"] = vector_to_json(traction.traction_pa);
    item["pressure_pa"] = traction.pressure_pa;
    value["tractions"].push_back(std::move(item));
  }
  for (const NodalForce& force : problem.nodal_forces) {
    value["nodal_forces"].push_back({{"vertex", force.vertex}, {"force_n", vector_to_json(force.force_n)}});
  }
  for (const auto& [key, field] : {std::pair{"body_force_n_m3", &problem.body_force_n_m3},
                                   std::pair{"held_field_m", &problem.held_field_m}}) {
    if (field->empty()) continue;
    value[key] = json::array();
    for (const Vec3& v : *field) value[key].push_back(vector_to_json(v));
  }
  return value;
}

BoundaryProblem problem_from_json(const json& json_value, const TetMesh& mesh, const std::string& where) {
  return ProblemReader(mesh, where).read(json_value);
}

DeformTask read_deform_task(const Request& request) {
  if (request.contest != "deform") throw InputError("contest", 0, "deform", request.contest);
  DeformTask task;
  task.mesh = read_medit(request.input, ReadOrientation::kKeep).mesh;
  task.problem = problem_from_json(read_json_file(request.problem), task.mesh, request.problem.string());
  return task;
}

void write_displacement(const std::filesystem::path& path, std::span<const Vec3> displacement_m) {
  std::string text = std::string(kHeader) + "\n";
  for (std::size_t vertex = 0; vertex < displacement_m.size(); ++vertex) {
    const Vec3& u = displacement_m[vertex];
    require(is_finite(u), "a displacement that is written is finite");
    append_number(text, vertex);
    for (const double component : {u.x, u.y, u.z}) {
      text += ',';
      append_number(text, component);
    }
    text += '\n';
  }
  write_file_atomically(path, text);
}

std::vector<Vec3> read_displacement(const std::filesystem::path& path, std::size_t rows_vertices,
                                    std::size_t rows_edges) {
  refuse_no_file(path, "a displacement file");
  std::ifstream file(path);
  const std::string where = path.string();
  std::string line;
  if (!file || !std::getline(file, line)) throw InputError(where, 0, "a displacement file", "none");
  if (line != kHeader) throw InputError(where, 1, kHeader, line.substr(0, 80));
  std::vector<Vec3> displacement;
  displacement.reserve(rows_vertices + rows_edges);
  while (std::getline(file, line)) {
    std::string_view rest = line;
    std::size_t vertex = 0;
    Vec3 u;
    const bool fits = take_number(rest, vertex, false) && take_number(rest, u.x, false) &&
                      take_number(rest, u.y, false) && take_number(rest, u.z, true) && is_finite(u) &&
                      vertex == displacement.size();
    if (!fits) {
      throw InputError(where, displacement.size() + 2,
                       "vertex " + std::to_string(displacement.size()) + " and three finite numbers",
                       line.substr(0, 80));
    }
    displacement.push_back(u);
  }
  if (displacement.size() != rows_vertices && displacement.size() != rows_vertices + rows_edges) {
    throw InputError(where, 0,
                     std::to_string(rows_vertices) + " rows, or " +
                         std::to_string(rows_vertices + rows_edges) + " with edge midpoints",
                     std::to_string(displacement.size()));
  }
  return displacement;
}

}  // namespace palpate::reference

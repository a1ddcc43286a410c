#include "experiments/scene_writer/draft_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "core/base/error.h"
#include "core/base/number_text.h"

namespace palpate::experiments {
namespace {

constexpr double kSupportDepthM =
    0.010;  // E over it is the supports' stiffness a unit of area (docs/scenes.md)
constexpr double kPadDepthM = 0.002;

std::string list_of(const Vec3& v) {
  const auto number = [](double x) { return short_number(x == 0.0 ? 0.0 : x); };  // no "-0"
  return "[" + number(v.x) + ", " + number(v.y) + ", " + number(v.z) + "]";
}

std::string percent(double share) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.0f%%", 100.0 * share);
  return text.data();
}

void require_printable(const std::filesystem::path& path) {
  const std::string name = path.string();
  const auto odd = std::find_if(name.begin(), name.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte < 32 || byte == 127;
  });
  if (odd == name.end()) return;
  std::string shown;
  for (const char c : name) shown += static_cast<unsigned char>(c) < 32 || c == 127 ? '?' : c;
  throw InputError(shown, 0, "a path without control characters, to stand in a scene",
                   "character " + std::to_string(static_cast<unsigned char>(*odd)));
}

/// A path as a quoted scalar, relative to the scene where that is possible. Throws: InputError for a name
/// with a control character, which no YAML file may hold.
std::string quoted_path(const std::filesystem::path& organ, const std::filesystem::path& scene) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path folder = fs::absolute(scene).parent_path();
  fs::path path = fs::proximate(fs::absolute(organ), folder, error);
  if (error || path.empty()) path = fs::absolute(organ);
  require_printable(path);
  std::string text = "'";
  for (const char c : path.string()) text += c == '\'' ? std::string("''") : std::string(1, c);
  return text + "'";
}

std::string mesh_text(const SceneWish& wish, const SceneDraft& draft) {
  std::string text = "# The mesh: " + std::to_string(draft.mesh.points.size()) + " vertices, " +
                     std::to_string(draft.mesh.tets.size()) + " tetrahedra, " +
                     three_digits(100.0 * draft.size_m.x) + " x " + three_digits(100.0 * draft.size_m.y) +
                     " x " + three_digits(100.0 * draft.size_m.z) + " cm.";
  if (draft.is_surface) text += " Made anew from the surface where it is not kept; the same bytes each time.";
  text += "\n# unit_m is the length of the file's unit in metres, " + draft.unit_reason + ".\n";
  text += "mesh: {file: " + quoted_path(wish.organ, wish.scene);
  if (draft.vertices) text += ", vertices: " + std::to_string(*draft.vertices);
  if (wish.repair) text += ", repair: true";
  return text + ", unit_m: " + short_number(draft.unit_m) + "}\n\n";
}

std::string material_text(const SceneWish& wish) {
  return "# A soft organ, unless you know better: livers and kidneys have some 2 to 20 kPa, and hardly "
         "change their "
         "volume.\n"
         "material: {young_modulus_pa: " +
         short_number(wish.material.young_modulus_pa) +
         ", poisson_ratio: " + short_number(wish.material.poisson_ratio) +
         ", density_kg_m3: " + short_number(wish.material.density_kg_m3) +
         "}\n"
         "strain: small  # or large, for presses that turn or bend the organ\n"
         "# What simulate takes; others: {finite_elements: p2}, {springs: isotropy_patch, volume: "
         "node_average}.\n"
         "model: {smoothed: edge_node}\n\n";
}

std::string clamp_text(const SceneWish& wish, const SceneDraft& draft) {
  const Vec3 up = up_direction(draft.up);
  const std::string lies =
      (draft.up_is_chosen ? "# It lies on its broad side: up is the axis along which it is shortest, "
                          : "# Up is, as asked for, ") +
      draft.up + ", and gravity pulls along " + other_way(draft.up) +
      ".\n# palpate scene --up takes +x, -x, +y, -y, +z and -z.\n";
  return lies + "# What holds it: an elastic bed under the lowest " + percent(draft.support.share) +
         " of its height along " + draft.up + ", E / 10 mm a unit of area.\n# It takes hold of " +
         std::to_string(draft.support.faces) + " faces, " + percent(draft.support.area_share) +
         " of the skin.\n" + "clamp:\n  - {half_space: {normal: " + list_of(up) +
         ", share: " + short_number(draft.support.share) +
         "}, elastic_pa_per_m: " + short_number(wish.material.young_modulus_pa / kSupportDepthM) + "}\n\n";
}

std::string load_text(const SceneWish& wish, const SceneDraft& draft) {
  const PadRegion& pad = draft.pad;
  const Vec3 gravity = -9.81 * up_direction(draft.up);
  std::string text = "# What loads it: its weight, and a pad of " + three_digits(2000.0 * pad.radius_m) +
                     " mm on top (" + std::to_string(pad.faces) + " faces, " +
                     three_digits(2.0 * pad.radius_m / pad.mean_edge_m) +
                     " edges of the skin wide) that is\n# pushed in along the skin's normal by " +
                     three_digits(1000.0 * length(draft.push_m)) + " mm, 5% of the " +
                     three_digits(1000.0 * pad.thickness_m) +
                     " mm below it, through an elastic layer (E / 2 mm).\n"
                     "load:\n";
  text += "  - {gravity_m_s2: " + list_of(gravity);
  if (wish.is_dynamic) text += ", profile: {times_s: [0, 0.1], shares: [0, 1], smooth: true}";
  text += "}\n  - {displace: {sphere: {";
  text += pad.direction ? "surface_point: {direction: " + list_of(*pad.direction) + "}"
                        : "center_m: " + list_of(pad.center_m);
  text += ", radius_m: " + short_number(pad.radius_m) + "}, by_m: " + list_of(draft.push_m) +
          ", elastic_pa_per_m: " + short_number(wish.material.young_modulus_pa / kPadDepthM) + "}";
  if (wish.is_dynamic)
    text += ",\n     profile: {times_s: [0, 0.1], shares: [0, 1], smooth: true}, until_s: 0.25";
  return text + "}\n\n";
}

std::string analysis_text(const SceneWish& wish, const SceneDraft& draft) {
  if (!wish.is_dynamic) return "analysis: static\n\n";
  return "# Weight and pad come in 0.1 s; the pad lets go at 0.25 s.\n"
         "analysis:\n  dynamic:\n    integrator: symplectic_euler\n    time_step_s: auto  # 0.9 of the "
         "longest stable "
         "one\n    duration_s: 0.5\n    damping: {stiffness_s: 5.0e-4, mass_per_s: 20}\n    frames: 25\n    "
         "samples: "
         "500\n    probes_m: [" +
         list_of(draft.pad.center_m) + "]  # below the pad\n\n";
}

}  // namespace

Vec3 up_direction(const std::string& up) {
  if (std::find(kUpNames.begin(), kUpNames.end(), up) == kUpNames.end())
    throw InputError("--up", 0, "+x, -x, +y, -y, +z or -z", "\"" + up + "\"");
  const double sign = up.front() == '-' ? -1.0 : 1.0;
  const char axis = up.back();
  return {axis == 'x' ? sign : 0.0, axis == 'y' ? sign : 0.0, axis == 'z' ? sign : 0.0};
}

std::string other_way(const std::string& up) {
  return (up.front() == '-' ? "" : "-") + up.substr(up.size() - 1);
}

std::string write_draft(const SceneWish& wish, const SceneDraft& draft) {
  const std::string name = wish.scene.filename().string();
  return "# A first scene of " + wish.organ.filename().string() +
         ", drafted by palpate scene: everything here is a starting point.\n"
         "#   palpate check " +
         name + "\n#   palpate simulate " + name + " -o results\n#   palpate fit " + name +
         " -o fitted\n"
         "# docs/scenes.md says what else a scene can have. Lengths are in metres, all else in SI units.\n"
         "schema: palpate/scene/1\n\n" +
         mesh_text(wish, draft) + material_text(wish) + clamp_text(wish, draft) + load_text(wish, draft) +
         analysis_text(wish, draft) +
         "# What a model has to reach here, for palpate fit (docs/fit.md): the error of the deformation, "
         "and\n"
         "# seconds of the clock for a simulated one" +
         (wish.is_dynamic
              ? std::string(". ")
              : ": what steps of this organ would take in a simulator, though it is at rest here. "
                "Where one\n# answer at rest is all, take time_per_second_s out, or have answer_s "
                "(a first\n# answer) or rate_hz (further ones) in its place. ") +
         "Other commands leave it alone.\n"
         "require: {error: {measure: deformation_l2, at_most: 0.05}, time_per_second_s: 0.5}\n";
}

}  // namespace palpate::experiments

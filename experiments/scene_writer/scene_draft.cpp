#include "experiments/scene_writer/scene_draft.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/mesh/geometry.h"
#include "experiments/judging/judge_record.h"
#include "experiments/meshes/mesh_fill.h"
#include "experiments/meshes/mesh_source.h"
#include "experiments/scene_reader/scene.h"
#include "experiments/scene_reader/scene_problem.h"
#include "experiments/scene_writer/draft_text.h"
#include "experiments/scene_writer/unit_guess.h"

namespace palpate::experiments {
namespace {

constexpr std::uint64_t kUsualVertices = 1500;
constexpr double kPushShare = 0.05;  // of the thickness

/// "12.3 cm": three digits.
std::string shown_length(double metres) {
  const bool is_small = metres < 0.01;
  const bool is_large = metres >= 1.0;
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), "%.3g %s",
                metres * (is_small   ? 1000.0
                          : is_large ? 1.0
                                     : 100.0),
                is_small   ? "mm"
                : is_large ? "m"
                           : "cm");
  return text.data();
}

/// The mesh in its own unit. A surface that cannot have the usual count is filled as it is.
void make_mesh(const SceneWish& wish, SceneDraft& draft) {
  draft.is_surface = is_surface_file(wish.organ);
  if (!draft.is_surface) {
    if (wish.vertices || wish.repair)
      throw InputError(wish.organ.string() +
                       ": --vertices and --repair belong to a surface (.stl, .off, .obj, .ply)");
    MeditFile file = read_mesh(wish.organ);
    const Judgement judgement = judge_mesh(file.mesh);
    if (!judgement.violations.empty())
      throw InputError(wish.organ.string(), 0, "a valid mesh", judgement.violations.front());
    draft.mesh = std::move(file.mesh);
    draft.notes = std::move(file.notes);
    return;
  }
  draft.vertices = wish.vertices.value_or(kUsualVertices);
  MadeMesh made;
  try {
    made = mesh_surface_cached({wish.organ, {draft.vertices, std::nullopt}, wish.repair, wish.unit_m});
  } catch (const InputError&) {
    if (wish.vertices) throw;
    draft.vertices.reset();
    made = mesh_surface_cached({wish.organ, {}, wish.repair, wish.unit_m});
    draft.notes.push_back("it cannot be filled to " + std::to_string(kUsualVertices) +
                          " vertices: the skin is kept as it is");
  }
  draft.mesh = std::move(made.mesh);
  draft.notes.insert(draft.notes.begin(), made.notes.begin(), made.notes.end());
}

void choose_unit(const SceneWish& wish, SceneDraft& draft) {
  const BoundingBox box = bounding_box(draft.mesh.points);
  const double diagonal = length(box.high - box.low);
  if (wish.unit_m) {
    draft.unit_m = *wish.unit_m;
    draft.unit_reason = "given: " + shown_length(draft.unit_m * diagonal) + " across";
  } else {
    const auto guess = guess_unit(diagonal);
    if (!guess)
      throw InputError(wish.organ.string() +
                       ": expected --unit-m, the length of its unit in metres: its box is " +
                       short_number(diagonal) + " across, which is no organ of 1 to 60 cm in mm, cm or m");
    draft.unit_m = guess->unit_m;
    draft.unit_reason = "guessed: in " + unit_name(guess->unit_m) + " it is " +
                        shown_length(guess->unit_m * diagonal) + " across";
    for (const double other : guess->others)
      draft.unit_reason += ", in " + unit_name(other) + " it would be " + shown_length(other * diagonal);
  }
  require_body_size(draft.unit_m * diagonal);
  for (Vec3& p : draft.mesh.points) p = draft.unit_m * p;
  draft.size_m = draft.unit_m * (box.high - box.low);
}

/// Up is the axis along which the body is shortest by more than a hundredth, and z before y before x: so it
/// lies on its broad side.
void choose_up(const SceneWish& wish, SceneDraft& draft) {
  constexpr double kClearly = 0.99;
  draft.up = wish.up.value_or("z");
  if (draft.up.front() == '+') draft.up.erase(0, 1);
  draft.up_is_chosen = !wish.up;
  if (wish.up) return;
  double shortest = draft.size_m.z;
  for (const auto& [name, size] : {std::pair{"y", draft.size_m.y}, std::pair{"x", draft.size_m.x}}) {
    if (size >= kClearly * shortest) continue;
    shortest = size;
    draft.up = name;
  }
}

/// To two digits of the longest component, so that the text is short.
Vec3 rounded_vector(const Vec3& v) {
  const double step = std::pow(10.0, std::floor(std::log10(length(v))) - 1.0);
  const auto round = [&](double x) { return step * std::round(x / step); };
  return {round(v.x), round(v.y), round(v.z)};
}

}  // namespace

SceneDraft draft_scene(const SceneWish& wish) {
  SceneDraft draft;
  make_mesh(wish, draft);
  choose_unit(wish, draft);
  choose_up(wish, draft);
  const Vec3 up = up_direction(draft.up);
  draft.support = find_resting_region(draft.mesh, up);
  if (!draft.support.stands)
    draft.notes.push_back("its centre of mass is not over what it lies on: it may tip over; --up turns it");
  draft.pad = find_pad_region(draft.mesh, up);
  draft.push_m = rounded_vector(-kPushShare * draft.pad.thickness_m * draft.pad.normal);
  if (draft.pad.reaches_round)
    draft.notes.push_back(
        "the pad reaches round to the other side: the body is thinner there than the skin's edges (" +
        shown_length(draft.pad.mean_edge_m) + "); more --vertices make them shorter");
  if (!draft.pad.direction)
    draft.notes.push_back("no ray from the centroid upward meets the skin: the pad is on the highest face");
  draft.yaml = write_draft(wish, draft);
  return draft;
}

BoundaryProblem resolve_draft(const std::filesystem::path& file) {
  const Scene scene = read_scene(file);
  const MadeMesh made = build_scene_mesh(scene.mesh);
  const Scene placed = place_scene(scene, made.mesh);
  return scene.is_dynamic ? resolve_problem(placed, made.mesh) : build_problem(placed, made.mesh);
}

}  // namespace palpate::experiments

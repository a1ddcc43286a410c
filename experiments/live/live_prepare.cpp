#include "experiments/live/live_prepare.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/mesh/geometry.h"
#include "core/mesh/space_order.h"
#include "core/mesh/topology.h"
#include "core/simplify/refined/refined.h"
#include "experiments/files/scratch_folder.h"
#include "experiments/judging/judge_record.h"
#include "experiments/live/live_model.h"
#include "experiments/live/live_table.h"
#include "experiments/scene_reader/scene.h"
#include "experiments/scene_reader/scene_problem.h"
#include "experiments/scene_writer/scene_draft.h"
#include "experiments/scene_writer/unit_guess.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

constexpr double kUsualDampingPerS = 30.0;  ///< of mass: an organ's first mode is gone in half a second
constexpr double kPadDepthM = 0.002;        ///< a pad resists like so much of the material
constexpr double kPadShare = 0.04;          ///< of the skin, where a scene has no pad
constexpr double kLeastPadEdges = 1.5;      ///< its radius in mean edges of the skin

/// The scene of a source, and its mesh in metres.
struct Found {
  Scene scene;
  TetMesh mesh;
  std::string kind;
};

/// The scene that `palpate scene` would write for a mesh or a surface.
Found draft(const LiveWish& wish, std::vector<std::string>& notes) {
  const ScratchFolder scratch;
  SceneWish draft_wish;
  draft_wish.organ = fs::absolute(wish.source);
  draft_wish.scene = scratch.file("scene.yaml");
  draft_wish.unit_m = wish.unit_m;
  draft_wish.vertices = wish.vertices;
  draft_wish.material = wish.material.value_or(kUsualMaterial);
  const SceneDraft made = draft_scene(draft_wish);
  print_note(wish.source.string() + ": its unit is the " + unit_name(made.unit_m) + ", " + made.unit_reason);
  notes.insert(notes.end(), made.notes.begin(), made.notes.end());
  notes.push_back("It rests on elastic supports under its lowest part (" + made.up +
                  " is up), as palpate scene finds them.");
  write_file_atomically(draft_wish.scene, made.yaml);
  return {read_scene(draft_wish.scene), made.mesh, "mesh"};
}

Found read_given(const fs::path& file, const std::string& kind, std::vector<std::string>& notes) {
  Found found{read_scene(file), {}, kind};
  MadeMesh made = build_scene_mesh(found.scene.mesh);
  notes.insert(notes.end(), made.notes.begin(), made.notes.end());
  found.mesh = std::move(made.mesh);
  return found;
}

Found find_source(const LiveWish& wish, std::vector<std::string>& notes) {
  std::error_code error;
  const bool is_folder = fs::is_directory(wish.source, error);
  const std::string ending = wish.source.extension().string();
  const bool is_scene = is_folder || ending == ".yaml" || ending == ".yml";
  if (!fs::exists(wish.source, error))
    throw InputError(wish.source.string(), 0, "a mesh, a surface, a scene or the folder of a fit", "nothing");
  if (is_scene && (wish.unit_m || wish.vertices))
    throw InputError("--unit-m, --vertices", 0, "a mesh or a surface", "a scene, which has its own");
  if (is_scene && wish.material)
    throw InputError("--young-pa, --poisson, --density", 0, "a mesh or a surface",
                     "a scene, whose material is in it");
  if (!is_folder) return is_scene ? read_given(wish.source, "scene", notes) : draft(wish, notes);
  if (!fs::exists(wish.source / "fit.json", error))
    throw InputError(wish.source.string(), 0, "the folder of a fit, with fit.json", "none there");
  if (!fs::exists(wish.source / "scene.yaml", error))
    throw InputError(wish.source.string(), 0, "a fit that has chosen a model (scene.yaml)",
                     "one that found none");
  return read_given(wish.source / "scene.yaml", "fit", notes);
}

/// What holds the body, without its loads: the finger takes their place.
BoundaryProblem holding_of(Scene placed, const TetMesh& mesh) {
  placed.loads.clear();
  if (placed.clamps.empty())
    throw InputError(placed.file.string(), 0, "a clamp or a support: a free body would be pushed away",
                     "none");
  BoundaryProblem problem = build_problem(placed, mesh);
  problem.strain = StrainSize::kSmall;
  return problem;
}

/// The same on a simplified mesh, whose skin is that of the whole one to the bit.
BoundaryProblem carry_over(const BoundaryProblem& holding, const TetMesh& whole, const TetMesh& mesh) {
  std::map<std::array<double, 3>, Index> at;
  const std::vector<std::uint8_t> is_skin = build_boundary_vertex_flags(mesh);
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    const Vec3& p = mesh.points[v];
    if (is_skin[v] != 0) at[{p.x, p.y, p.z}] = static_cast<Index>(v);
  }
  const auto carry = [&](std::vector<Triangle>& faces) {
    for (Triangle& face : faces) {
      for (Index& v : face) {
        const Vec3& p = whole.points[v];
        const auto found = at.find({p.x, p.y, p.z});
        require(found != at.end(), "a simplified mesh with the whole one's skin");
        v = found->second;
      }
    }
  };
  BoundaryProblem out = holding;
  for (ElasticSupport& support : out.supports) carry(support.patch.faces);
  for (HeldFaces& held : out.held) carry(held.faces);
  return out;
}

/// Its radius: that of the scene's own pad, or what covers a share of the skin; a few edges wide at least.
double pad_radius(const Scene& placed, const TetMesh& mesh) {
  for (const SceneLoad& load : placed.loads) {
    if (load.kind != SceneLoad::Kind::kGravity && load.region.kind == Region::Kind::kSphere)
      return load.region.radius;
  }
  double area = 0.0;
  double edges = 0.0;
  const std::vector<Triangle> skin = build_boundary(mesh);
  for (const Triangle& face : skin) {
    const Vec3& a = mesh.points[face[0]];
    const Vec3& b = mesh.points[face[1]];
    area += 0.5 * length(cross(b - a, mesh.points[face[2]] - a));
    edges += length(b - a) / static_cast<double>(skin.size());
  }
  constexpr double kPi = 3.14159265358979323846;
  return std::max(std::sqrt(kPadShare * area / kPi), kLeastPadEdges * edges);
}

void add_levels(const std::vector<double>& ratios, LiveBodyData& out) {
  for (const double ratio : ratios) {
    LiveLevel level{ratio, out.levels.front().mesh, {}, {}, {}};
    const std::string percent = short_number(100.0 * ratio) + "%";
    simplify::RefinedOptions options;
    options.stop.ratio = ratio;
    const simplify::RefinedReport report = simplify_refined(level.mesh, options);
    if (report.stop != "ratio") {
      out.notes.push_back("Not simplified by " + percent + ": only " +
                          std::to_string(report.tets_in - report.tets_out) + " of " +
                          std::to_string(report.tets_in) + " tetrahedra can go while the skin stays.");
      continue;
    }
    const Judgement judgement = judge_mesh(level.mesh);
    if (!judgement.violations.empty()) {
      out.notes.push_back("Not simplified by " + percent + ": " + judgement.violations.front());
      continue;
    }
    const LiveLevel& whole = out.levels.front();
    level.holding = carry_over(whole.holding, whole.mesh, level.mesh);
    out.levels.push_back(std::move(level));
  }
}

}  // namespace

LiveBodyData prepare_live(const LiveWish& wish, const Registry& registry) {
  LiveBodyData out;
  Found found = find_source(wish, out.notes);
  // Steps on general forces are a quarter faster so (docs/live.md).
  std::vector<Index> given_number = sort_in_space(found.mesh).vertices;
  const Scene placed = place_scene(found.scene, found.mesh);
  out.title =
      found.kind == "scene" ? placed.name : fs::absolute(wish.source).lexically_normal().stem().string();
  out.kind = found.kind;
  out.material = placed.material;
  out.damping_mass_per_s = kUsualDampingPerS;
  if (placed.is_dynamic && placed.dynamic.damping_mass_per_s + placed.dynamic.damping_stiffness_s > 0.0) {
    out.damping_mass_per_s = placed.dynamic.damping_mass_per_s;
    out.damping_stiffness_s = placed.dynamic.damping_stiffness_s;
  }
  out.pad_radius_m = pad_radius(placed, found.mesh);
  out.pad_pa_per_m = out.material.young_modulus_pa / kPadDepthM;
  out.levels.push_back({0.0, found.mesh, holding_of(placed, found.mesh), {}, std::move(given_number)});
  add_levels({0.3, 0.5, 0.7}, out);
  if (wish.with_table) {
    make_live_table(registry, out);
  } else {
    out.no_table = "it was not asked for";
  }
  choose_start(placed, registry, out);
  return out;
}

}  // namespace palpate::experiments

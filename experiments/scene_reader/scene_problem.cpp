#include "experiments/scene_reader/scene_problem.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/base/component.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/mesh/face_weights.h"
#include "core/mesh/geometry.h"
#include "core/mesh/rigid_motion.h"
#include "core/mesh/topology.h"
#include "experiments/judging/judge_record.h"
#include "experiments/judging/patch_carrier.h"
#include "experiments/text/nearest_name.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace {

constexpr int kParts = 16;             // a face's edge is divided into so many
constexpr double kLeastWeight = 1e-6;  // a face with less is left out
constexpr double kRounding =
    1e-9;  // of the box's diagonal: a face in the plane of a half-space belongs to it

/// Share of a triangle in a region: of kParts^2 equal parts, those whose centroid lies in it.
double share_inside(const Region& region, const Vec3& a, const Vec3& b, const Vec3& c, double tolerance) {
  int inside = 0;
  for_each_part([&](double u, double v) {
    inside += is_inside(region, a + u * (b - a) + v * (c - a), tolerance) ? 1 : 0;
  });
  return static_cast<double>(inside) / kPartsOfFace;
}

double area_of(const TetMesh& mesh, const Triangle& face) {
  const Vec3& a = mesh.points[face[0]];
  return 0.5 * length(cross(mesh.points[face[1]] - a, mesh.points[face[2]] - a));
}

}  // namespace

std::string size_complaint(const SceneMesh& how, const TetMesh& mesh) {
  constexpr double kLongestBody = 5.0;     // m
  constexpr double kShortestBody = 0.001;  // m
  const double longest = longest_side(bounding_box(mesh.points));
  if (longest <= kLongestBody && longest >= kShortestBody) return "";
  const std::string by = how.unit_m ? "unit_m: " + short_number(*how.unit_m)
                                    : "length_m: " + short_number(how.length_m.value_or(longest));
  return "with " + by + " the body is " + short_number(longest) +
         " m long: is that its size? (unit_m is the length of the mesh's unit in metres, 0.001 for "
         "millimetres)";
}

namespace {

/// Resolves one scene on one mesh.
class ProblemBuilder {
 public:
  ProblemBuilder(const Scene& scene, const TetMesh& mesh)
      : scene_(scene), mesh_(mesh), boundary_(build_boundary(mesh)) {
    const BoundingBox box = bounding_box(mesh.points);
    tolerance_ = kRounding * length(box.high - box.low);
    if (scene.whole != nullptr) carrier_.emplace(*scene.whole);
  }

  BoundaryProblem build() {
    problem_.material = scene_.material;
    problem_.strain = scene_.strain;
    for (const SceneClamp& clamp : scene_.clamps) add_clamp(clamp);
    for (const SceneLoad& load : scene_.loads) add_load(load);
    return std::move(problem_);
  }

 private:
  void require_placed(const Region& region) const {
    require(!region.surface_direction && !region.radius_relative && !region.share,
            "build_problem: a region is not placed");
  }

  [[noreturn]] void fail_empty(const Region& region, const std::string& who, const std::string& what) const {
    const std::string unit = unit_complaint(region, mesh_);
    const std::string size = size_complaint(scene_.mesh, mesh_);
    throw InputError(region.where + ": " + who + ": the region (" + region.text + ") " +
                     (unit.empty() ? what : "selects nothing: " + unit) + (size.empty() ? "" : "; " + size));
  }

  void check_unit(const Region& region, const std::string& who) const {
    const std::string unit = unit_complaint(region, mesh_);
    if (!unit.empty())
      throw InputError(region.where + ": " + who + ": the region (" + region.text +
                       ") is in the wrong place: " + unit);
  }

  /// A region's faces; `scale` multiplies what acts on them, so that no weight is above 1.
  struct WeighedPatch {
    FacePatch patch;
    double scale = 1.0;
  };

  double share_of(const Region& region, const TetMesh& mesh, const Triangle& face) const {
    return share_inside(region, mesh.points[face[0]], mesh.points[face[1]], mesh.points[face[2]], tolerance_);
  }

  WeighedPatch patch_of(const Region& region, const std::string& who) const {
    require_placed(region);
    WeighedPatch out;
    if (carrier_) {
      const auto share = [&](const Triangle& face) { return share_of(region, carrier_->whole(), face); };
      out.patch = carrier_->carry(share, mesh_, boundary_, out.scale);
    } else {
      for (const Triangle& face : boundary_) {
        const double share = share_of(region, mesh_, face);
        if (share <= 0.0) continue;
        out.patch.faces.push_back(face);
        out.patch.weight.push_back(share);
      }
    }
    if (out.patch.faces.empty()) fail_empty(region, who, "selects nothing of the skin");
    check_unit(region, who);
    return out;
  }

  ElasticSupport support_of(const Region& region, const std::string& who, double stiffness_pa_per_m,
                            const Vec3& by_m) const {
    WeighedPatch weighed = patch_of(region, who);
    return {std::move(weighed.patch), weighed.scale * stiffness_pa_per_m, by_m};
  }

  std::vector<Triangle> held_faces(const Region& region, const std::string& who) const {
    require_placed(region);
    std::vector<Triangle> faces;
    for (const Triangle& face : boundary_) {
      const bool all = std::all_of(face.begin(), face.end(),
                                   [&](Index v) { return is_inside(region, mesh_.points[v], tolerance_); });
      if (all) faces.push_back(face);
    }
    if (faces.empty())
      fail_empty(region, who, "selects nothing: no face of the skin has all three vertices in it");
    check_unit(region, who);
    return faces;
  }

  void hold(HeldFaces held, const Region& region, const std::string& who) {
    for (const Triangle& face : held.faces) {
      for (const Index vertex : face) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          if (held.axes[axis]) hold_vertex(vertex, axis, component(held.by_m, axis), region, who);
        }
      }
    }
    problem_.held.push_back(std::move(held));
  }

  void hold_vertex(Index vertex, std::size_t axis, double by, const Region& region, const std::string& who) {
    const auto [at, is_new] = held_.emplace(std::pair{vertex, axis}, Hold{by, region.where});
    if (is_new || at->second.by == by) return;
    throw InputError(region.where + ": " + who + ": contradicts " + at->second.where + ": vertex " +
                     std::to_string(vertex) + " is to move by " + short_number(by) + " m and by " +
                     short_number(at->second.by) + " m along " + "xyz"[axis]);
  }

  void add_clamp(const SceneClamp& clamp) {
    if (clamp.elastic_pa_per_m) {
      problem_.supports.push_back(support_of(clamp.region, "clamp", *clamp.elastic_pa_per_m, {}));
      return;
    }
    hold({held_faces(clamp.region, "clamp"), clamp.axes, {}}, clamp.region, "clamp");
  }

  void add_load(const SceneLoad& load) {
    switch (load.kind) {
      case SceneLoad::Kind::kGravity:
        problem_.gravity_m_s2 = load.vector;
        return;
      case SceneLoad::Kind::kDisplace:
        if (load.elastic_pa_per_m) {
          problem_.supports.push_back(
              support_of(load.region, "displace", *load.elastic_pa_per_m, load.vector));
        } else {
          hold({held_faces(load.region, "displace"), {true, true, true}, load.vector}, load.region,
               "displace");
        }
        return;
      case SceneLoad::Kind::kForce: {
        Traction traction{patch_of(load.region, "force").patch, {}, 0.0};
        double area = 0.0;
        for (std::size_t i = 0; i < traction.patch.faces.size(); ++i)
          area += traction.patch.weight[i] * area_of(mesh_, traction.patch.faces[i]);
        traction.traction_pa = (1.0 / area) * load.vector;
        problem_.tractions.push_back(std::move(traction));
        return;
      }
    }
    throw ContractError("add_load: unknown kind");
  }

  struct Hold {
    double by;
    std::string where;
  };

  const Scene& scene_;
  const TetMesh& mesh_;
  std::vector<Triangle> boundary_;
  double tolerance_ = 0.0;
  std::optional<PatchCarrier> carrier_;
  BoundaryProblem problem_;
  std::map<std::pair<Index, std::size_t>, Hold> held_;
};

}  // namespace

MadeMesh build_scene_mesh(const SceneMesh& mesh, std::optional<std::uint64_t> vertices) {
  MadeMesh made;
  if (mesh.shape) {
    ShapeRequest shape = *mesh.shape;
    if (vertices) shape.size = {*vertices, std::nullopt};
    made = make_shape(shape);
  } else if (is_surface_file(mesh.file)) {
    const MeshSize size = vertices ? MeshSize{*vertices, std::nullopt} : mesh.size;
    made = mesh_surface_cached({mesh.file, size, mesh.repair});
  } else {
    if (vertices) throw InputError(mesh.file.string() + ": a mesh from a file has the vertices that it has");
    MeditFile file = read_mesh(mesh.file);
    const Judgement judgement = judge_mesh(file.mesh);
    if (!judgement.violations.empty())
      throw InputError(mesh.file.string(), 0, "a valid mesh", judgement.violations.front());
    made = {std::move(file.mesh), std::move(file.notes)};
  }
  const double scale =
      mesh.unit_m ? *mesh.unit_m : *mesh.length_m / longest_side(bounding_box(made.mesh.points));
  for (Vec3& point : made.mesh.points) point = scale * point;
  const std::string odd = size_complaint(mesh, made.mesh);
  if (!odd.empty()) made.notes.push_back(odd);
  return made;
}

namespace {

/// A tool that goes farther than the body is long would take its patch out of it.
void check_tool_stays(const SceneLoad& load, const TetMesh& mesh) {
  const double longest = longest_side(bounding_box(mesh.points));
  double share = load.profile ? 0.0 : 1.0;
  if (load.profile) {
    for (const double each : load.profile->share) share = std::max(share, std::abs(each));
  }
  const double way = share * length(load.vector);
  if (way > longest)
    throw InputError(load.where + ": the tool leaves the organ: it is moved by " + short_number(way) +
                     " m, and the organ is " + short_number(longest) + " m long");
}

/// What is carried over is for the same body: boxes agree to a tenth of their diagonal.
void check_same_body(const SceneMesh& mesh, const BoundingBox& whole, const BoundingBox& own) {
  const double most = 0.1 * length(own.high - own.low);
  if (length(whole.low - own.low) <= most && length(whole.high - own.high) <= most) return;
  throw InputError(mesh.regions_from.string(), 0,
                   "the mesh that " + mesh.file.string() + " was made from, in metres",
                   "one whose box is elsewhere: " + short_number(length(whole.high - whole.low)) +
                       " m across, not " + short_number(length(own.high - own.low)));
}

}  // namespace

Scene place_scene(Scene scene, const TetMesh& mesh) {
  if (!scene.mesh.regions_from.empty() && scene.whole == nullptr) {
    SceneMesh whole = scene.mesh;
    whole.file = scene.mesh.regions_from;
    scene.whole = std::make_shared<const TetMesh>(build_scene_mesh(whole).mesh);
    check_same_body(scene.mesh, bounding_box(scene.whole->points), bounding_box(mesh.points));
  }
  const TetMesh& placed_on = scene.whole != nullptr ? *scene.whole : mesh;
  for (SceneClamp& clamp : scene.clamps) clamp.region = place_region(clamp.region, placed_on);
  for (SceneLoad& load : scene.loads) {
    if (load.kind != SceneLoad::Kind::kGravity) load.region = place_region(load.region, placed_on);
    if (load.kind == SceneLoad::Kind::kDisplace) check_tool_stays(load, mesh);
  }
  if (scene.require) {
    for (ErrorPlace& place : scene.require->places) {
      if (!place.probe) place.region = place_region(place.region, placed_on);
    }
  }
  return scene;
}

Scene on_whole(Scene placed, const TetMesh& whole) {
  if (placed.whole == nullptr) placed.whole = std::make_shared<const TetMesh>(whole);
  return placed;
}

BoundaryProblem resolve_problem(const Scene& placed, const TetMesh& mesh) {
  return ProblemBuilder(placed, mesh).build();
}

BoundaryProblem build_problem(const Scene& placed, const TetMesh& mesh) {
  BoundaryProblem problem = resolve_problem(placed, mesh);
  const std::vector<RigidMotion> free = find_free_motions(mesh, resisted_axes(mesh, problem));
  if (free.empty()) return problem;
  std::vector<std::string> motions;
  for (const RigidMotion& motion : free) {
    if (motion.part == free[0].part) motions.push_back(rigid_motion_text(motion));
  }
  const std::string part =
      free[0].part == 0 ? "" : " of the part of the mesh with vertex " + std::to_string(free[0].part);
  const char* which = motions.size() == 6   ? "every rigid motion"
                      : motions.size() == 1 ? "a rigid motion"
                                            : "rigid motions";
  throw InputError(placed.file.string() + ": the clamps leave " + which + part + " free" +
                   (motions.size() < 6 ? ": " + joined(motions) : ""));
}

}  // namespace palpate::experiments

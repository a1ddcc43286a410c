// A scene: a body, what holds it and what loads it, as data (palpate/scene/1), in SI units.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/mesh/boundary_problem.h"
#include "core/mesh/tet_mesh.h"
#include "experiments/meshes/mesh_source.h"
#include "experiments/registry/contestant.h"
#include "experiments/registry/method_options.h"
#include "experiments/registry/registry.h"
#include "experiments/scene_reader/region.h"
#include "experiments/scene_reader/scene_dynamic.h"
#include "experiments/scene_reader/scene_require.h"

namespace palpate::experiments {

/// The body's mesh: a shape that is made, a file, or the file of a surface that is filled; and what its unit
/// of length is.
struct SceneMesh {
  std::optional<ShapeRequest> shape;
  std::filesystem::path file;      ///< when there is no shape; resolved against the scene's folder
  MeshSize size{};                 ///< of a file with a surface (is_surface_file)
  bool repair = false;             ///< mend that surface
  std::optional<double> unit_m;    ///< length of the mesh's unit
  std::optional<double> length_m;  ///< else: what the longest side of its box becomes
  /// Of a file with tets in metres that was made from another one: that one, in metres too; resolved against
  /// the scene's folder. What takes hold of its skin is carried over. Empty: regions are the mesh's own.
  std::filesystem::path regions_from;
};

/// What holds the body on a region of its skin: elastically, or hard in the directions of `axes`.
struct SceneClamp {
  Region region;
  std::optional<double> elastic_pa_per_m;
  std::array<bool, 3> axes{true, true, true};
};

/// One load.
struct SceneLoad {
  enum class Kind { kGravity, kDisplace, kForce };

  Kind kind = Kind::kGravity;
  Region region;                           ///< not for kGravity
  Vec3 vector;                             ///< m/s^2, m or N (the total over the region)
  std::optional<double> elastic_pa_per_m;  ///< kDisplace: through an elastic pad
  std::string where;                       ///< "kidney.yaml:12", for messages
  /// In a dynamic scene: how much of it there is at each time; nothing: all of it.
  std::optional<dynamics::TimeProfile> profile;
  double from_s = 0.0;            ///< the load, with what it holds, is there from this time ...
  std::optional<double> until_s;  ///< ... to this one; nothing: to the end
};

/// The scene's own choice of a model, for `simulate`; contests bring their own.
struct SceneModel {
  std::string method;  ///< "springs.isotropy_patch", "fem.p2"
  std::map<std::string, GivenOption> set;
};

struct Scene {
  std::filesystem::path file;
  std::string name;  ///< the file's name without its ending
  SceneMesh mesh;
  Material material;
  StrainSize strain = StrainSize::kSmall;
  std::optional<SceneModel> model;
  std::vector<SceneClamp> clamps;
  std::vector<SceneLoad> loads;
  bool is_dynamic = false;     ///< `analysis: {dynamic: ...}`
  SceneDynamic dynamic;        ///< of a dynamic one
  std::string analysis_where;  ///< "kidney.yaml:20"
  /// Points that have a name. Of a dynamic scene they are written to history.csv, after its own.
  std::vector<SceneProbe> probes;
  std::optional<SceneRequirement> require;  ///< for `palpate fit`
  /// Of a fitted scene: how far its model may be taken (palpate/envelope/1); resolved against the scene's
  /// folder.
  std::optional<std::filesystem::path> envelope;
  /// Of a placed scene on a simplified mesh: the whole one, in metres, whose skin the regions belong to.
  std::shared_ptr<const TetMesh> whole;
};

/// Reads and checks a scene.
///
/// Throws: InputError "file:line: ..." for unknown keys (with the nearest), wrong types, values out of range,
///         a mesh file that is not there, no load that does anything.
Scene read_scene(const std::filesystem::path& path);

/// The parts of a scene, for files that combine them (palpate train). `folder` is where a mesh file's path
/// starts. Throws: as read_scene.
SceneMesh read_scene_mesh(const YamlValue& value, const std::filesystem::path& folder);
Material read_scene_material(const YamlValue& value);
SceneClamp read_scene_clamp(const YamlValue& value);
SceneLoad read_scene_load(const YamlValue& value);
/// The method that the scene's model stands for. Throws: InputError without a model, or for an unknown one
/// (with the nearest).
MethodEntry find_model(const Scene& scene, const Registry& registry);

/// Throws: InputError unless -1 < ratio < 0.5; `at` names the place.
void check_poisson_ratio(const YamlValue& at, double ratio);

/// The scene that a plan names: experiments/scenes/NAME.yaml, NAME without an ending.
std::filesystem::path scene_path(const std::string& name);

/// The names of the scenes in experiments/scenes, sorted.
std::vector<std::string> scene_names();

}  // namespace palpate::experiments

#include "experiments/scene_reader/scene.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "experiments/files/places.h"
#include "experiments/scene_reader/shape_fields.h"
#include "experiments/text/nearest_name.h"
#include "experiments/text/yaml_schema.h"

namespace palpate::experiments {
namespace {

constexpr double kSmallest = 1e-30;
constexpr double kLargest = 1e30;

std::string place_of(const YamlValue& value) {
  return value.file() + ":" + std::to_string(value.line());
}

double read_positive(const YamlValue& value) {
  const double number = value.number();
  if (!(number > 0.0)) value.fail_expected("a number above 0");
  return value.number(kSmallest, kLargest);
}

/// The unit of a made shape that has one: "mm" 0.001, "cm" 0.01; nothing for shapes without.
std::optional<double> unit_of_shape(const std::string& name) {
  for (const ShapeInfo& info : list_shapes()) {
    if (info.name != name) continue;
    if (info.unit == "mm") return 0.001;
    if (info.unit == "cm") return 0.01;
  }
  return std::nullopt;
}

/// {springs: NAME, option: value, ...}, {finite_elements: p1 | p2}, {tensor_mass: true}, {smoothed: NAME},
/// {reduced: compliance}.
SceneModel read_model(const YamlValue& value) {
  static const std::vector<std::string> kinds{"springs", "finite_elements", "tensor_mass", "smoothed",
                                              "reduced"};
  SceneModel model;
  for (const auto& [key, entry] : value.entries()) {
    if (std::find(kinds.begin(), kinds.end(), key) == kinds.end()) {
      model.set[key] = {entry.text(), place_of(entry)};
      continue;
    }
    if (!model.method.empty()) entry.fail("a scene takes one model, not two");
    if (key == "springs") model.method = "springs." + entry.identifier();
    if (model.method == "springs.trained")
      entry.fail_expected(
          "springs that are found on the mesh (trained ones are a file's, and plans name it)");
    if (key == "smoothed") model.method = "smoothed." + entry.identifier();
    if (key == "reduced") model.method = "reduced." + entry.identifier();
    if (key == "finite_elements") model.method = "fem." + entry.identifier();
    if (key != "tensor_mass") continue;
    if (!entry.boolean()) entry.fail_expected("true");
    model.method = "tensor_mass";
  }
  if (model.method.empty()) value.fail("model: expected one of " + joined(kinds));
  return model;
}

std::array<bool, 3> read_axes(const YamlValue& value) {
  static const std::vector<std::string> names{"x", "y", "z"};
  std::array<bool, 3> axes{false, false, false};
  for (const YamlValue& item : value.items()) {
    const auto found = std::find(names.begin(), names.end(), item.text());
    if (found == names.end()) item.fail_expected("x, y or z");
    bool& axis = axes.at(static_cast<std::size_t>(found - names.begin()));
    if (axis) item.fail("axis " + item.text() + " twice");
    axis = true;
  }
  if (axes == std::array<bool, 3>{false, false, false}) value.fail_expected("at least one of x, y and z");
  return axes;
}

/// When a load is there: for dynamic scenes.
void read_times(const YamlFields& fields, SceneLoad& load) {
  if (const auto profile = fields.find("profile")) load.profile = read_profile(*profile);
  if (const auto from = fields.find("from_s")) load.from_s = from->number(0.0, 1e300);
  if (const auto until = fields.find("until_s")) {
    load.until_s = until->number(0.0, 1e300);
    if (!(*load.until_s > load.from_s)) until->fail_expected("a time after from_s");
  }
}

SceneLoad read_load(const YamlValue& value) {
  const YamlFields fields =
      value.fields({"gravity_m_s2", "displace", "force", "profile", "from_s", "until_s"});
  const auto kinds = {fields.find("gravity_m_s2"), fields.find("displace"), fields.find("force")};
  if (std::count_if(kinds.begin(), kinds.end(), [](const auto& kind) { return kind.has_value(); }) != 1)
    value.fail("a load is one of gravity_m_s2, displace and force");
  SceneLoad load;
  load.where = place_of(value);
  read_times(fields, load);
  if (const auto gravity = fields.find("gravity_m_s2")) load.vector = read_vector(*gravity);
  if (const auto displace = fields.find("displace")) {
    const YamlFields keys = displace->fields({"sphere", "half_space", "box", "by_m", "elastic_pa_per_m"});
    load.kind = SceneLoad::Kind::kDisplace;
    load.region = read_region(keys);
    load.vector = read_vector(keys.need("by_m"));
    if (const auto elastic = keys.find("elastic_pa_per_m")) load.elastic_pa_per_m = read_positive(*elastic);
  }
  if (const auto force = fields.find("force")) {
    const YamlFields keys = force->fields({"sphere", "half_space", "box", "total_n"});
    load.kind = SceneLoad::Kind::kForce;
    load.region = read_region(keys);
    load.vector = read_vector(keys.need("total_n"));
  }
  return load;
}

void read_loads(const YamlValue& value, Scene& scene) {
  bool acts = false;
  bool has_gravity = false;
  for (const YamlValue& item : value.items()) {
    scene.loads.push_back(read_load(item));
    const SceneLoad& load = scene.loads.back();
    acts = acts || length(load.vector) > 0.0;
    if (load.kind != SceneLoad::Kind::kGravity) continue;
    if (has_gravity) item.fail("gravity twice");
    has_gravity = true;
  }
  if (!acts) value.fail("load: expected one that does something, found none");
}

void read_analysis(const YamlValue& value, Scene& scene) {
  scene.analysis_where = place_of(value);
  if (value.is_map()) {
    const YamlFields keys = value.fields({"dynamic"});
    scene.dynamic = read_dynamic(keys.need("dynamic"));
    scene.is_dynamic = true;
    return;
  }
  if (value.text() != "static") value.fail_expected("static or {dynamic: ...}");
}

/// A preset has springs of its own, or takes the scene's; the rest of the model is the preset's.
void check_preset(const Scene& scene) {
  if (!scene.is_dynamic || scene.dynamic.preset.empty() || !scene.model) return;
  const std::string preset = scene.analysis_where + ": the preset " + scene.dynamic.preset;
  if (!scene.model->method.starts_with("springs."))
    throw InputError(preset + " takes springs alone as a model, not " + scene.model->method);
  for (const char* key : {"volume", "volume_force_ratio", "law", "theta", "shear"}) {
    if (scene.model->set.contains(key)) throw InputError(preset + " sets " + key + " by itself");
  }
}

/// What fits a dynamic scene alone, or not to its preset.
void check_times(const Scene& scene) {
  for (const SceneLoad& load : scene.loads) {
    const bool has_times = load.profile || load.until_s || load.from_s > 0.0;
    if (has_times && !scene.is_dynamic)
      throw InputError(load.where + ": profile, from_s and until_s belong to a dynamic analysis");
  }
  check_preset(scene);
}

StrainSize read_strain(const YamlValue& value) {
  const std::string text = value.text();
  if (text != "small" && text != "large") value.fail_expected("small or large");
  return text == "small" ? StrainSize::kSmall : StrainSize::kLarge;
}

std::filesystem::path scenes_folder() {
  return std::filesystem::path(source_folder()) / "experiments" / "scenes";
}

/// All probes by name: those that have one, and a dynamic scene's own as history.csv names them. The former
/// are written there, too.
std::vector<SceneProbe> name_probes(const YamlFields& fields, Scene& scene) {
  std::vector<SceneProbe> named = scene.probes;
  std::vector<Vec3>& written = scene.dynamic.probes_m;
  for (std::size_t k = 0; k < written.size(); ++k) {
    named.push_back({"probe_" + std::to_string(k + 1), written[k]});
    for (const SceneProbe& probe : scene.probes) {
      if (probe.name == named.back().name)
        fields.need("probes_m")
            .fail("\"" + probe.name + "\" is what a probe of the analysis is called already");
    }
  }
  if (scene.is_dynamic) {
    for (const SceneProbe& probe : scene.probes) written.push_back(probe.place_m);
  }
  return named;
}

}  // namespace

void check_poisson_ratio(const YamlValue& at, double ratio) {
  constexpr double kLeast = 1e-7;  // nearer to either end, rounding is as large as the answer
  if (!(ratio > -1.0 + kLeast && ratio < 0.5 - kLeast))
    at.fail_expected("a Poisson ratio above -1 and below 0.5, by more than 1e-7");
}

SceneMesh read_scene_mesh(const YamlValue& value, const std::filesystem::path& folder) {
  const YamlFields fields =
      value.fields(with_shape_keys({"make", "file", "repair", "unit_m", "length_m", "regions_from"}));
  SceneMesh mesh;
  const auto make = fields.find("make");
  const auto file = fields.find("file");
  if (make.has_value() == file.has_value()) value.fail("a mesh needs one of \"make\" and \"file\"");
  const auto unit = fields.find("unit_m");
  const auto size = fields.find("length_m");
  if (unit && size) size->fail("a mesh takes \"unit_m\" or \"length_m\", not both");
  if (unit) mesh.unit_m = read_positive(*unit);
  if (size) mesh.length_m = read_positive(*size);
  const auto repair = fields.find("repair");
  if (repair && !(file && is_surface_file(file->text())))
    repair->fail("\"repair\" belongs to the file of a surface (.stl, .off, .obj, .ply)");
  if (make) {
    mesh.shape = read_shape_fields(fields, *make);
    if (!unit && !size) mesh.unit_m = unit_of_shape(mesh.shape->name);
  } else {
    mesh.file = folder / file->text();
    if (is_surface_file(mesh.file)) {
      mesh.size = read_surface_size(fields);
      mesh.repair = repair && repair->boolean();
    } else {
      refuse_shape_keys(fields);
    }
    std::error_code error;
    if (!std::filesystem::is_regular_file(mesh.file, error))
      file->fail("expected a mesh file, found none at " + mesh.file.string());
  }
  if (const auto whole = fields.find("regions_from")) {
    if (make || is_surface_file(mesh.file) || mesh.unit_m != 1.0)
      whole->fail("\"regions_from\" belongs to a file with tetrahedra in metres (unit_m: 1)");
    mesh.regions_from = folder / whole->text();
    std::error_code error;
    if (!std::filesystem::is_regular_file(mesh.regions_from, error))
      whole->fail("expected a mesh file, found none at " + mesh.regions_from.string());
  }
  if (!mesh.unit_m && !mesh.length_m)
    value.fail("how long is the mesh? It needs \"unit_m\" (0.001 for millimetres) or \"length_m\"");
  return mesh;
}

Material read_scene_material(const YamlValue& value) {
  const YamlFields fields = value.fields({"young_modulus_pa", "poisson_ratio", "density_kg_m3"});
  Material material;
  material.young_modulus_pa = read_positive(fields.need("young_modulus_pa"));
  const YamlValue ratio = fields.need("poisson_ratio");
  material.poisson_ratio = ratio.number();
  check_poisson_ratio(ratio, material.poisson_ratio);
  material.density_kg_m3 = read_positive(fields.need("density_kg_m3"));
  return material;
}

SceneClamp read_scene_clamp(const YamlValue& value) {
  const YamlFields fields = value.fields({"sphere", "half_space", "box", "elastic_pa_per_m", "axes"});
  SceneClamp clamp;
  clamp.region = read_region(fields);
  const auto elastic = fields.find("elastic_pa_per_m");
  const auto axes = fields.find("axes");
  if (elastic) clamp.elastic_pa_per_m = read_positive(*elastic);
  if (elastic && axes) axes->fail("axes belong to a hard clamp: an elastic one holds in all directions");
  if (axes) clamp.axes = read_axes(*axes);
  return clamp;
}

SceneLoad read_scene_load(const YamlValue& value) {
  SceneLoad load = read_load(value);
  if (load.profile || load.until_s || load.from_s > 0.0)
    value.fail("profile, from_s and until_s belong to a dynamic analysis");
  return load;
}

Scene read_scene(const std::filesystem::path& path) {
  const YamlValue root = read_yaml(path);
  require_schema(root, "palpate/scene/1");
  const YamlFields fields = root.fields({"schema", "mesh", "material", "strain", "model", "clamp", "load",
                                         "analysis", "probes_m", "require", "envelope"});
  Scene scene;
  scene.file = path;
  scene.name = path.stem().string();
  scene.mesh = read_scene_mesh(fields.need("mesh"), path.parent_path());
  scene.material = read_scene_material(fields.need("material"));
  if (const auto strain = fields.find("strain")) scene.strain = read_strain(*strain);
  if (const auto model = fields.find("model")) scene.model = read_model(*model);
  if (scene.model && scene.model->set.count("frozen") > 0) {
    std::string& file = scene.model->set["frozen"].text;
    file = std::filesystem::absolute(path.parent_path() / file).lexically_normal().string();
  }
  if (const auto clamp = fields.find("clamp")) {
    for (const YamlValue& item : clamp->items()) scene.clamps.push_back(read_scene_clamp(item));
  }
  read_loads(fields.need("load"), scene);
  read_analysis(fields.need("analysis"), scene);
  if (const auto probes = fields.find("probes_m")) scene.probes = read_probes(*probes);
  const std::vector<SceneProbe> named = name_probes(fields, scene);
  if (const auto require = fields.find("require")) scene.require = read_requirement(*require, named);
  if (const auto envelope = fields.find("envelope")) scene.envelope = path.parent_path() / envelope->text();
  check_times(scene);
  return scene;
}

MethodEntry find_model(const Scene& scene, const Registry& registry) {
  if (!scene.model)
    throw InputError(scene.file.string() + ": the key \"model\" is missing: what is to solve it?");
  const auto entry = registry.find(scene.model->method);
  if (!entry || entry->contestant->contest != "deform") {
    std::vector<std::string> known;
    for (const std::string& name : registry.method_names()) {
      if (registry.find(name)->contestant->contest == "deform") known.push_back(name);
    }
    throw InputError(scene.file.string() + ": model: unknown method \"" + scene.model->method + "\"" +
                     nearest_hint(scene.model->method, known));
  }
  return *entry;
}

std::filesystem::path scene_path(const std::string& name) {
  return scenes_folder() / (name + ".yaml");
}

std::vector<std::string> scene_names() {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(scenes_folder(), error)) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace palpate::experiments

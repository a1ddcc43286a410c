#include "experiments/scene_reader/scene_require.h"

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/mesh/geometry.h"
#include "experiments/text/nearest_name.h"

namespace palpate::experiments {
namespace {

constexpr double kLeastTolerance = 1e-4;
constexpr double kMostTolerance = 1.0;
constexpr double kLeastTime = 1e-9;
constexpr double kMostTime = 1e9;

/// An error as scenes name it, and the judge's measures of it: of the whole body, and at some points alone.
struct ErrorKind {
  const char* name;
  const char* measure;
  const char* measure_at;  ///< null: it has no place
};

constexpr std::array<ErrorKind, 5> kErrors{{
    {"deformation_l2", "displacement_deformation", "displacement_deformation_at"},
    {"relative_l2", "displacement_l2", "displacement_l2_at"},
    {"energy", "displacement_energy", nullptr},
    {"max", "displacement_max", "displacement_max_at"},
    {"pad_force", "pad_force", nullptr},
}};

const ErrorKind& read_error_kind(const YamlValue& value) {
  const std::string name = value.text();
  std::vector<std::string> known;
  for (const ErrorKind& kind : kErrors) {
    if (name == kind.name) return kind;
    known.emplace_back(kind.name);
  }
  value.fail("unknown error \"" + name + "\"" + nearest_hint(name, known));
}

ErrorPlace read_error_place(const YamlValue& value, const std::vector<SceneProbe>& probes) {
  ErrorPlace place;
  place.where = value.file() + ":" + std::to_string(value.line());
  if (value.is_map()) {
    place.region = read_region(value.fields({"sphere", "half_space", "box"}));
    return place;
  }
  const std::string name = value.text();
  std::vector<std::string> known;
  for (const SceneProbe& probe : probes) {
    if (probe.name == name) place.probe = probe;
    known.push_back(probe.name);
  }
  if (!place.probe)
    value.fail("the scene has no probe \"" + name + "\"" +
               (known.empty() ? std::string("; probes_m: {" + name + ": [x, y, z]} would make it one")
                              : nearest_hint(name, known)));
  return place;
}

std::vector<ErrorPlace> read_error_places(const YamlValue& value, const ErrorKind& kind,
                                          const std::vector<SceneProbe>& probes) {
  if (kind.measure_at == nullptr)
    value.fail(std::string("the error \"") + kind.name +
               "\" is of the whole body: \"at\" goes with deformation_l2, relative_l2 and max");
  std::vector<ErrorPlace> places;
  std::set<std::string> names;
  for (const YamlValue& item : value.is_list() ? value.items() : std::vector<YamlValue>{value}) {
    places.push_back(read_error_place(item, probes));
    const ErrorPlace& place = places.back();
    if (place.probe && !names.insert(place.probe->name).second)
      item.fail("\"" + place.probe->name + "\" twice");
    if (place.probe.has_value() != places.front().probe.has_value())
      item.fail(
          "probes count alike and the vertices of a region by their volume: \"at\" takes one or the other");
  }
  if (places.empty()) value.fail_expected("at least one probe or region");
  return places;
}

/// Refuses a probe that cannot have been meant for this mesh: its unit must be wrong.
void check_probe(const ErrorPlace& place, const TetMesh& mesh) {
  const BoundingBox box = bounding_box(mesh.points);
  const double side = longest_side(box);
  const double off = length(place.probe->place_m - 0.5 * (box.low + box.high));
  if (off <= 2.0 * side) return;
  throw InputError(place.where + ": the probe " + place.probe->name + " is " + short_number(off) +
                   " m from the middle of the mesh, which is " + short_number(side) +
                   " m long: is it in metres, and is the mesh's unit right?");
}

void read_changes(const YamlValue& value, SceneRequirement& require) {
  const std::vector<std::string>& known = changeable_things();
  for (const YamlValue& item : value.items()) {
    const std::string name = item.text();
    if (std::find(known.begin(), known.end(), name) == known.end())
      item.fail("unknown thing that may change \"" + name + "\"" + nearest_hint(name, known));
    if (std::find(require.needs.begin(), require.needs.end(), name) != require.needs.end())
      item.fail("\"" + name + "\" twice");
    require.needs.push_back(name);
  }
}

}  // namespace

const std::vector<std::string>& changeable_things() {
  static const std::vector<std::string> things{"supports", "material", "cuts"};
  return things;
}

std::vector<SceneProbe> read_probes(const YamlValue& value) {
  std::vector<SceneProbe> probes;
  for (const auto& [name, place] : value.entries()) probes.push_back({name, read_vector(place)});
  return probes;
}

std::vector<std::size_t> find_error_points(const SceneRequirement& placed, const TetMesh& mesh) {
  constexpr double kRoundedTo = 1e-9;  // of the mesh's longest side: a vertex in a region's border is in it
  const double tolerance = kRoundedTo * longest_side(bounding_box(mesh.points));
  std::set<std::size_t> found;
  for (const ErrorPlace& place : placed.places) {
    if (place.probe) {
      check_probe(place, mesh);
      found.insert(nearest_point(mesh.points, place.probe->place_m));
      continue;
    }
    bool is_empty = true;
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
      if (!is_inside(place.region, mesh.points[v], tolerance)) continue;
      is_empty = false;
      found.insert(v);
    }
    if (!is_empty) continue;
    const std::string unit = unit_complaint(place.region, mesh);
    throw InputError(place.where + ": require.error.at: the region (" + place.region.text +
                     ") has no vertex of the mesh in it" + (unit.empty() ? "" : ": " + unit));
  }
  return {found.begin(), found.end()};
}

SceneRequirement read_requirement(const YamlValue& value, const std::vector<SceneProbe>& probes) {
  const YamlFields fields = value.fields(
      {"error", "time_per_second_s", "rate_hz", "answer_s", "memory_bytes", "large_strain", "may_change"});
  const YamlFields error = fields.need("error").fields({"measure", "at_most", "at"});
  SceneRequirement require;
  const ErrorKind& kind = read_error_kind(error.need("measure"));
  require.measure = kind.measure;
  if (const auto at = error.find("at")) {
    require.places = read_error_places(*at, kind, probes);
    require.measure = kind.measure_at;
  }
  require.at_most = error.need("at_most").number(kLeastTolerance, kMostTolerance);
  if (const auto given = fields.find("time_per_second_s"))
    require.time_per_second_s = given->number(kLeastTime, kMostTime);
  if (const auto given = fields.find("rate_hz")) require.rate_hz = given->number(1.0 / kMostTime, kMostTime);
  if (const auto given = fields.find("answer_s")) {
    if (require.rate_hz || require.time_per_second_s)
      given->fail(
          "answer_s is of one answer with its set-up: it goes with neither rate_hz nor time_per_second_s");
    require.answer_s = given->number(kLeastTime, kMostTime);
  }
  if (require.rate_hz && require.time_per_second_s)
    fields.need("rate_hz").fail(
        "rate_hz is of answers at rest, time_per_second_s of a model that moves: a scene takes one of them");
  if (const auto given = fields.find("memory_bytes"))
    require.memory_bytes = static_cast<std::uint64_t>(given->number(1.0, 1e15));
  if (const auto given = fields.find("may_change")) read_changes(*given, require);
  if (const auto given = fields.find("large_strain"); given && given->boolean())
    require.needs.emplace_back("large_strain");
  return require;
}

}  // namespace palpate::experiments

// What a scene requires of a model: tolerance and budget, for `palpate fit`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/mesh/tet_mesh.h"
#include "experiments/scene_reader/region.h"
#include "experiments/text/yaml_value.h"

namespace palpate::experiments {

/// A point of a scene that has a name.
struct SceneProbe {
  std::string name;
  Vec3 place_m;
};

/// Where alone an error is asked for: at a probe's nearest vertex, or at all vertices in a region.
struct ErrorPlace {
  std::optional<SceneProbe> probe;
  Region region;      ///< where there is no probe
  std::string where;  ///< "kidney.yaml:30", for messages
};

/// What is to be reached, and what must remain possible.
struct SceneRequirement {
  std::string measure;                      ///< of the judge: "displacement_deformation", ...
  std::vector<ErrorPlace> places{};         ///< probes alone or regions alone; empty: the whole body
  double at_most = 0.0;                     ///< of that error, relative
  std::optional<double> time_per_second_s;  ///< of the clock, for a simulated second
  std::optional<double> rate_hz;            ///< answers a second
  std::optional<double> answer_s;           ///< of the clock, for a first answer
  std::optional<std::uint64_t> memory_bytes;
  std::vector<std::string> needs;  ///< of what a model can do: "large_strain", "supports", "cuts", ...
};

/// What a scene may ask to remain changeable, beside its loads.
const std::vector<std::string>& changeable_things();

/// Reads the mapping below `require`:
///
///   require:
///     error: {measure: deformation_l2, at_most: 0.05}   # relative_l2, energy, max, pad_force
///     # error: {..., at: [tip]} or {..., at: [{sphere: ...}]}: probes of the scene, or regions
///     time_per_second_s: 0.5      # wall time of a simulated second: a model that moves
///     rate_hz: 1000               # at rest: answers to new loads a second
///     answer_s: 1                 # at rest: the first answer, set-up and all
///     memory_bytes: 500000000
///     large_strain: true
///     may_change: [supports, cuts]
///
/// Throws: InputError with file and line, also for two budgets that exclude each other, a probe that the
/// scene has not, and a measure that has no place.
SceneRequirement read_requirement(const YamlValue& value, const std::vector<SceneProbe>& probes = {});

/// Reads {NAME: [x, y, z], ...}. Throws: InputError.
std::vector<SceneProbe> read_probes(const YamlValue& value);

/// The vertices at which a requirement's error is asked for, sorted; none where it has no places. Requires:
/// placed regions (place_scene). Throws: InputError with the place of a region that has no vertex in it, and
/// of a probe that is farther from the mesh's box than that is long.
std::vector<std::size_t> find_error_points(const SceneRequirement& placed, const TetMesh& mesh);

}  // namespace palpate::experiments

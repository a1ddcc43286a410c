// How a mesh is to be graded by its scene, as plans and the command line ask for it.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "experiments/registry/contestant.h"
#include "experiments/registry/method_options.h"
#include "experiments/registry/registry.h"
#include "experiments/text/yaml_value.h"

namespace palpate::experiments {

/// Given regions, a pilot solve's error estimate, or both: the lesser size counts.
struct GradeWish {
  /// What the mesh is to be fine at: "loads" (pads and forces), "pads", "forces", "supports", "probes"
  /// of the scene, and regions in metres ("sphere x y z r", "half_space nx ny nz offset"). Empty: nothing is
  /// given.
  std::vector<std::string> near;
  double near_size = 0.6;         ///< wanted edge length there over that far away, in (0, 1]
  double radius_m = 0.0;          ///< so far from such a place the mesh is as fine as at it
  std::optional<double> reach_m;  ///< where sizes reach 1; nothing: a quarter of the box's diagonal
  std::string pilot;  ///< method of the contest deform whose error is estimated; empty: no pilot solve
  std::map<std::string, GivenOption> pilot_set;
  double least_size = 0.6;  ///< no size by the error is smaller, in (0, 1]
  double growth = 0.25;     ///< neighbouring edges: how much longer, over the distance in wanted edge lengths
};

/// Reads {near: [pads], near_size: 0.6, radius_m: 0.005, reach_m: 0.03, pilot: {method: ..., set: {...}} or a
/// name, least_size: 0.6, growth: 0.25}. Throws: InputError with file and line for what is out of range, an
/// unknown word or method, and where neither near nor pilot is there.
GradeWish read_grade(const YamlValue& value, const Registry& registry);

/// Throws: InputError "near: ..." unless the text is one of the words or a region. Returns the text.
std::string check_near(const std::string& text, const std::string& where);

/// Checks the method of a pilot solve. Throws: InputError for one that is unknown or of another contest.
MethodEntry find_pilot(const std::string& method, const Registry& registry, const std::string& where);

}  // namespace palpate::experiments

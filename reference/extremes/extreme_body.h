// A body of the contest stability: springs, masses and damping on the mesh and problem of a request.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "core/dynamics/motion/motion_model.h"
#include "reference/door/stability_problem.h"

namespace palpate::reference {

/// How the material becomes a model.
struct BodyModel {
  std::string springs = "uniform";
  std::string volume = "none";
  std::string tets = "none";  ///< the law of linear tetrahedra that take the place of the springs
  std::string smoothing =
      "none";  ///< of that law: "edge_node" has the shear over edges, the dilatation at nodes
};

/// Takes the model's options out of `options`. Throws: InputError for a wrong type.
BodyModel take_body_model(nlohmann::json& options);

/// A body that can be moved, and what there is to say of it: "vertices", "tets", "springs", "rate_per_s" (w
/// of DampingLaw), "mass_ratio", "volume_ratio".
struct BuiltBody {
  dynamics::MotionModel model;
  double size_m = 0.0;  ///< longest side
  nlohmann::json report;
};

/// The body, for large strain, with the problem's factors and damping. Throws: InputError for a mesh with
/// flat tets or a setting that the model refuses.
BuiltBody build_extreme_body(const StabilityTask& task, const BodyModel& wanted);

}  // namespace palpate::reference

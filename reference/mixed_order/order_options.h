// Options and tasks that the methods of this folder share.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "core/dynamics/elasticity/loads.h"
#include "reference/door/deform_problem.h"
#include "reference/door/request_options.h"
#include "reference/mixed_order/adapted_body.h"

namespace palpate::reference {

/// Options of all of them.
struct CommonOptions {
  std::string factor = "auto";
  bool midpoints = false;  ///< rows for the midpoints of the organ's edges too
};

/// Takes factor and midpoints. Throws: InputError.
inline CommonOptions take_common_options(nlohmann::json& left) {
  CommonOptions options;
  const std::vector<std::string> factors{"auto", "cholmod", "eigen"};
  options.factor = factors[take_choice(left, "factor", factors)];
  options.midpoints =
      take_option<bool>(left, "midpoints", &nlohmann::json::is_boolean, "true or false", false);
  return options;
}

/// Takes ratio, near_size and reach. Throws: InputError.
inline AdaptOptions take_adapt_options(nlohmann::json& left) {
  AdaptOptions options;
  options.ratio = take_number(left, "ratio", 0.0, 0.95, options.ratio);
  options.near_size = take_number(left, "near_size", 0.05, 1.0, options.near_size);
  options.reach = take_number(left, "reach", 0.001, 10.0, options.reach);
  return options;
}

/// The task of a request. Throws: InputError for large strain, and for a body that is left free.
inline DeformTask read_small_task(const Request& request) {
  DeformTask task = read_deform_task(request);
  if (task.problem.strain == StrainSize::kLarge)
    throw InputError("strain", 0, "small: " + request.method + " is linear", "large");
  dynamics::require_no_rigid_motion(task.mesh, dynamics::build_loads(task.mesh, task.problem));
  return task;
}

}  // namespace palpate::reference

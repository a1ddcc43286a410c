// What a plan of the contest stability adds: extremes, each a few settings and what is swept of them.
#pragma once

#include <vector>

#include "experiments/case_list.h"
#include "experiments/plan.h"
#include "experiments/yaml_value.h"

namespace palpate::experiments {

/// Reads the list of extremes:
///
///   - name: stiffness
///     meshes: [kidney]                      # absent: all of the plan
///     contestants: [motion.runge_kutta_4]   # labels; absent: all
///     simplify: unchecked                   # label of a simplifier of the plan; absent: the mesh as it is
///     set: {damping: drag}                  # options of the contestants
///     sweep: {stiffness_factor: [1.0e-9, 1.0e9]}   # options too; every value with every other
///
/// Throws: InputError with file and line: for unknown meshes, labels and options (with the nearest), values
/// that an option refuses, an option both set and swept.
std::vector<PlanExtreme> read_extremes(const YamlValue& value, const Plan& plan, const Registry& registry);

/// The cases of such a plan, "kidney/motion.plain_float/stiffness/stiffness_factor=1e9", extreme after
/// extreme.
std::vector<Case> build_stability_cases(const Plan& plan, const Registry& registry);

}  // namespace palpate::experiments

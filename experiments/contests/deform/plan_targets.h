// Targets of a contest of displacements, and sets of its scenes: read, checked, and left to the report.
#pragma once

#include "experiments/plan_reader/plan.h"
#include "experiments/text/yaml_value.h"

namespace palpate::experiments {

/// Reads and checks the keys "scene_sets" and "targets" of a plan, if it has them:
///
///   scene_sets: {organs: [kidney_gravity, liver_gravity]}
///   targets:
///     - {text: ..., labels: [a, b], scenes: [organs], at: {poisson_ratio: 0.25, vertices: 1503},
///        at_most: 0.02}
///
/// The best of the labels has to keep every scene (or set) within at_most of `measure`, displacement_l2
/// unless another one is named; `at` picks values of the sweep, one or a list. The report reads them from the
/// plan itself (report/deform/targets.py). Requires: plan.scenes, plan.sweep and plan.contestants are read.
/// Throws: InputError with file and line for an unknown scene, set, label, axis or value (with the nearest).
void check_targets(const YamlFields& fields, const Plan& plan);

}  // namespace palpate::experiments

// What a plan of the contest stability adds: extremes, each a few settings and what is swept of them.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "experiments/plan_reader/case_list.h"
#include "experiments/plan_reader/plan.h"
#include "experiments/text/yaml_value.h"

namespace palpate::experiments {

/// Settings of the contest stability that are swept together.
struct PlanExtreme {
  std::string name;
  std::vector<std::size_t> meshes;        ///< indices into Plan::meshes
  std::vector<std::size_t> contestants;   ///< and into Plan::contestants
  std::optional<std::size_t> simplifier;  ///< and into Plan::simplifiers
  std::map<std::string, GivenOption> set;
  std::vector<SweepAxis> sweep;  ///< of options, by their plain names
};

/// What the contest stability alone reads.
struct StabilityPart : ContestPart {
  std::vector<PlanExtreme> extremes;
};

/// Reads it (see ContestKind::read), with its list of extremes:
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
void read_stability_plan(const YamlFields& fields, Plan& plan, const Registry& registry);

/// The cases of such a plan, "kidney/motion.plain_float/stiffness/stiffness_factor=1e9", extreme after
/// extreme.
std::vector<Case> build_stability_cases(const Plan& plan, const Registry& registry);

}  // namespace palpate::experiments

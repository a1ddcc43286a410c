// Meshes that a plan's simplifiers make of a problem's own, for contests that hold what is answered on them
// against the whole one.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "core/mesh/boundary_problem.h"
#include "core/mesh/tet_mesh.h"
#include "experiments/contests/contest.h"

namespace palpate::experiments {

/// What came of a simplifier.
struct SimplifiedMesh {
  std::string failure;  ///< why there is none; empty if there is
  TetMesh mesh;         ///< in metres
  nlohmann::json report;
  std::optional<double> kernel_s;
  nlohmann::json grading;  ///< of a graded one: GradedSizes::facts; else null
};

/// Simplifies a mesh in metres (which the simplifier sees in millimetres), or takes the answer from the
/// cache. `folder` takes the mesh that is handed over, and the sizes of a simplifier that is graded by
/// `problem`, which only such a one needs. A mesh that the judge finds invalid, or that has lost
/// no tetrahedra where some were to go, is a failure.
SimplifiedMesh simplify_mesh(const TetMesh& whole, const PlanContestant& simplifier, const Stop& stop,
                             const std::filesystem::path& folder, const ContestSetting& setting,
                             const BoundaryProblem* problem = nullptr);

/// Whether a case has a mesh of a simplifier of its plan, and not the one as it is.
bool is_simplified(const Plan& plan, const Case& run_case);

/// "kidney_gravity/poisson_ratio=0.45/simplify=refined/tets_removed_ratio=0.5" of a problem's id.
std::string simplified_id(const Plan& plan, const Case& run_case, const std::string& problem_id);

/// Reads `simplify`: simplifiers as in a contest of their own, and "none" for the mesh as it is. The sweep
/// tets_removed_ratio is theirs. Returns the axes that are left for the contestants. Throws: InputError with
/// file and line.
std::vector<SweepAxis> read_simplifiers(const YamlFields& fields, Plan& plan, const Registry& registry);

}  // namespace palpate::experiments

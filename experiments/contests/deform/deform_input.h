// The inputs of a contest of displacements: each scene as a problem on its mesh, its reference, simplified
// meshes.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/judge/displacement/reference_estimate.h"
#include "core/mesh/boundary_problem.h"
#include "core/mesh/tet_mesh.h"
#include "experiments/contests/contest.h"
#include "experiments/contests/problem_files.h"
#include "experiments/plan_reader/case_list.h"
#include "experiments/plan_reader/plan.h"

namespace palpate::experiments {

/// One problem of a run: a scene at one Poisson ratio and one size of mesh.
struct DeformInput {
  std::string id;  ///< "kidney_gravity", then "/poisson_ratio=0.45" and "/vertices=1503" where they are swept
  std::string scene;                                ///< its name in the plan
  nlohmann::json sweep = nlohmann::json::object();  ///< of the problem alone
  Scene placed;
  ProblemFiles own;
  std::optional<judge::ChosenPoints> chosen;  ///< of its own mesh: where the scene asks for an error
};

/// What came of the reference.
struct DeformReference {
  std::string failure;                    ///< why there is none; empty if there is
  std::string outcome = "accepted";       ///< of its record
  judge::ReferenceEstimate estimate;      ///< at the vertices of the problem's own mesh
  std::vector<Vec3> field;                ///< estimate.field, and then the same at the midpoints of the edges
  std::optional<double> whole_energy;     ///< relative energy error of `field`, quadratic in each tet
  std::vector<Vec3> pad_force_n;          ///< on the body, of each pad that moves, at the finest level
  std::optional<double> pad_force_error;  ///< how far the level before is from it, over its size
  std::vector<nlohmann::json> levels;     ///< what each level reports, with its times
  bool interrupted = false;
};

/// A mesh that a simplifier made of a problem's own, with the same problem on it.
struct SimplifiedInput {
  std::string failure;  ///< why there is none; empty if there is
  ProblemFiles files;
  std::optional<double> kernel_s;  ///< of the simplifier
  nlohmann::json grading;          ///< where it was graded: what by
};

/// Makes the mesh, places the scene on it and writes both below `folder`.
/// Throws: InputError or UnavailableError as build_scene_mesh and build_problem do.
DeformInput build_input(const PlanScene& scene, const nlohmann::json& sweep,
                        const std::filesystem::path& folder);

/// Names what a problem's stiffness is made of: the mesh, the material, what holds the body. Problems of one
/// name differ in their loads alone, and can share a factorisation. Empty where it cannot be shared: large
/// strain, or held faces that move.
std::string stiffness_name(const ProblemFiles& files);

/// Solves the reference on the problem's mesh and its refinements; what an earlier run solved is taken from
/// the cache. `companions` are problems of the same stiffness that come later: they are solved along, as far
/// as it is certain that they will be asked for (a third level where their own second one is not enough).
DeformReference solve_reference(const DeformInput& input, const ContestSetting& setting,
                                std::span<const DeformInput* const> companions = {});

/// Simplifies the problem's mesh (or takes the mesh from the cache) and puts the problem on it.
SimplifiedInput simplify_input(const DeformInput& input, const PlanContestant& simplifier, const Stop& stop,
                               const std::filesystem::path& folder, const ContestSetting& setting);

}  // namespace palpate::experiments

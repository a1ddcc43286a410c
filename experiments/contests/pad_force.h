// The force of a held pad by finite elements: what the engine's force is held against.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/mesh/boundary_problem.h"
#include "core/mesh/tet_mesh.h"
#include "experiments/contests/contest.h"
#include "experiments/scene_reader/scene.h"

namespace palpate::experiments {

/// Whether a support is a pad that moves.
bool is_moved(const ElasticSupport& support);

/// sqrt(sum |f - t|^2 / sum |t|^2) over the pads; not finite where the truth is zero. Throws: ContractError
/// if the sizes differ.
double relative_force_error(std::span<const Vec3> force, std::span<const Vec3> truth);

/// The pad on one mesh of the reference.
struct PadLevel {
  Vec3 force_n;              ///< of the pad on the body
  Vec3 reaction_n;           ///< of all other elastic supports on the body
  double by_force_j = 0.0;   ///< the pad's movement . its force
  double potential_j = 0.0;  ///< energy of the body and of all supports
};

/// What came of it.
struct PadForce {
  std::string failure;               ///< why there is none; empty if there is
  std::string outcome = "accepted";  ///< of its record
  Vec3 force_n;                      ///< on the body, at the finest level
  std::optional<double> change;      ///< from the level before, over the size of the force
  std::vector<nlohmann::json> levels;
  std::vector<std::string> faults;  ///< find_pad_faults; with any, `failure` says so
  bool interrupted = false;
};

/// The static problem that a dynamic scene comes to rest in: each load as its profile leaves it. Throws:
/// InputError for a scene with loads that go before the end, without one elastic pad that is its only tool,
/// or as build_problem.
BoundaryProblem build_held_problem(const Scene& placed, const TetMesh& mesh);

/// The force of an elastic pad on the body: the integral of stiffness x (by - u) over its faces, exact for a
/// field that is quadratic on each of them: one third of the values at the edge midpoints.
/// Shape:  one value a vertex and one an edge midpoint of build_edges(mesh).
Vec3 measure_pad_force(const TetMesh& mesh, const ElasticSupport& pad, std::span<const Vec3> field);

/// What the levels of a quadratic reference, coarsest first, say against each other and against mechanics.
/// Where the pad is all that moves the body:
///
///   - its force and the reactions of the supports add up to zero (without hard clamps);
///   - a linear body holds by . F = 2 W, W the energy of body and supports;
///   - each refinement lowers W, as the spaces are nested and W is the least energy in each; and by . F with
///   it
///     (= 2 W for small strain; for large strain a force that breaks this is not used before someone looked).
///
/// Returns: one sentence a fault; none where something else moves the body too.
std::vector<std::string> find_pad_faults(const BoundaryProblem& problem, std::span<const PadLevel> levels);

/// Solves the held problem with the plan's reference, on the mesh and on those of its uniform refinements
/// that have at most 120,000 tetrahedra, each as a problem of its own, so that the force is integrated over
/// the faces of the mesh that the solution lives on. What an earlier run solved is taken from the cache.
/// Files go below `folder`.
PadForce solve_pad_force(const Scene& placed, const TetMesh& mesh, const std::filesystem::path& folder,
                         const ContestSetting& setting);

}  // namespace palpate::experiments

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
#include "experiments/contest.h"
#include "experiments/scene.h"

namespace palpate::experiments {

/// What came of it.
struct PadForce {
  std::string failure;               ///< why there is none; empty if there is
  std::string outcome = "accepted";  ///< of its record
  Vec3 force_n;                      ///< on the body, at the finest level
  std::optional<double> change;      ///< from the level before, over the size of the force
  std::vector<nlohmann::json> levels;
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

/// Solves the held problem with the plan's reference, at those of its levels whose mesh has at most 120,000
/// tetrahedra; what an earlier run solved is taken from the cache. Files go below `folder`.
PadForce solve_pad_force(const Scene& placed, const TetMesh& mesh, const std::filesystem::path& folder,
                         const ContestSetting& setting);

}  // namespace palpate::experiments

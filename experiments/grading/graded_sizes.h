// The sizes that a scene wants its mesh to have, at the vertices of the mesh that there is.
#pragma once

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "core/mesh/boundary_problem.h"
#include "core/mesh/tet_mesh.h"
#include "experiments/grading/grade_wish.h"

namespace palpate::experiments {

/// A body and what is done to it, in metres.
struct GradedBody {
  const TetMesh& mesh;
  const BoundaryProblem& problem;
  std::span<const Vec3> probes_m;
};

/// How the pilot solve runs.
struct PilotSetting {
  const Registry& registry;
  std::filesystem::path folder;  ///< takes the pilot's mesh and problem; made if it is not there
  int threads = 1;
  const volatile std::sig_atomic_t* stop_flag = nullptr;
};

/// Sizes, and what came of finding them.
struct GradedSizes {
  std::string failure;        ///< why there are none; empty if there are
  std::vector<double> sizes;  ///< one a vertex, relative: simplify::write_sizes
  double far_m = 0.0;         ///< the edge length where a size is 1, for the count
  nlohmann::json facts;       ///< far_m, least_size, touched_vertices, pilot and its times
};

/// Sizes for a mesh of so many tets.
///
///   given:  near_size + (1 - near_size) (3 t^2 - 2 t^3), t = min(1, max(0, distance - radius) / reach),
///           to the faces that are held, supported, pressed or loaded, the points probed, the regions
///   pilot:  simplify::sizes_of_errors of the pilot's displacement (its own static solve, at small strain)
///
/// the lesser of both; then growth is limited, and no size is below what the mesh has. A pilot that does not
/// converge is a failure. Throws: InputError for a word that the scene has nothing of, a region that no tet
/// meets, or no fewer tets than the mesh has.
GradedSizes find_graded_sizes(const GradeWish& wish, const GradedBody& body, std::uint64_t tets,
                              const PilotSetting& setting);

}  // namespace palpate::experiments

// The door of the contest `stability`: the body that is driven, as a file. See PROTOCOL.md.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/mesh/boundary_problem.h"
#include "core/mesh/tet_mesh.h"
#include "reference/door/adapter.h"

namespace palpate::reference {

/// Laws of damping. With w the root of the largest row sum of |M^-1 K| of the contestant's own body without
/// factors (an upper bound on its fastest motion), k and m its mean spring constant and mass, and z the
/// damping ratio:
///
///   none
///   stiffness        springs 2 z / w x their constant, strain terms alike
///   mass             vertices 2 z w x their mass
///   axial, isotropic all springs 2 z k / w
///   drag             all vertices 2 z w m
enum class DampingLaw { kNone, kStiffness, kMass, kAxial, kIsotropic, kDrag };

/// A body and the displacement from which its runs start, without speed.
struct StabilityProblem {
  Material material;
  double stiffness_factor = 1.0;     ///< all stiffness times this, after the damping was found
  std::vector<double> mass_factors;  ///< one a vertex: its lumped mass times this, alike
  DampingLaw damping = DampingLaw::kNone;
  double damping_ratio = 0.0;
  std::vector<Index> held;    ///< vertices that do not move, rising
  std::vector<Vec3> start_m;  ///< one a vertex; held ones zero
  std::uint64_t seed = 1;     ///< of what a contestant draws
};

/// The problem as JSON (palpate/stability_problem/1):
///
///   {"schema": "palpate/stability_problem/1",
///    "material": {"young_modulus_pa": 10000, "poisson_ratio": 0.25, "density_kg_m3": 1050},
///    "stiffness_factor": 1, "mass_factors": [1, ...], "damping": {"law": "axial", "ratio": 0.05},
///    "held": [0, 3], "start_m": [[0, 0, 1e-7], ...], "seed": 1}
nlohmann::json stability_to_json(const StabilityProblem& problem);

/// Reads it back and checks it against the mesh: E > 0, -1 < nu < 0.5, density > 0, factors and ratio that
/// are finite and not negative (of masses: above zero), a start of each vertex, held vertices that rise and
/// do not start elsewhere. Throws: InputError that starts with `where`.
StabilityProblem stability_from_json(const nlohmann::json& json, const TetMesh& mesh,
                                     const std::string& where);

/// What a request of the contest stability asks: the mesh in metres, positively oriented, and its body.
struct StabilityTask {
  TetMesh mesh;
  StabilityProblem problem;
};

/// Reads both files of a request. Throws: InputError, also for a request of another contest.
StabilityTask read_stability_task(const Request& request);

}  // namespace palpate::reference

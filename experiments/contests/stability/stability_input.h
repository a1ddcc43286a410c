// The body of a case: the plan's mesh driven to an extreme, with what holds it, its factors and where its
// runs start.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>

#include "core/mesh/tet_mesh.h"
#include "reference/door/stability_problem.h"

namespace palpate::experiments {

/// What a request of the contest stability names: the mesh in metres and its problem.
struct StabilityInput {
  TetMesh mesh;
  reference::StabilityProblem problem;
  std::size_t flattened = 0;      ///< tets
  double min_dihedral_deg = 0.0;  ///< smallest of the mesh
};

/// Makes it from the settings among `options` (experiments/contestants/stability_settings.h); what is not
/// there has its default. The material is 10 kPa at 1050 kg/m^3. Held is the tenth of the body at the low end
/// of its longest side, x. A vertex's mass factor is mass_factor x mass_ratio^r with r random in [0, 1). The
/// start, from rest, with L the longest side and s the strain: random: up to s L along each axis; stretch,
/// shear: s times the distance from the low end, along x or y; invert: -2 s times the distance beyond three
/// quarters of the length, along x.
///
/// Throws: InputError for settings without sense, and a mesh that is left with flat tets.
StabilityInput build_stability_input(const TetMesh& mesh, const nlohmann::json& options);

/// The options without those that make the body: what a contestant is asked.
nlohmann::json own_options(const nlohmann::json& options);

}  // namespace palpate::experiments

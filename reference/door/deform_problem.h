// The door of the contest `deform`: the problem as a file, and the displacement as a file. See PROTOCOL.md.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "core/mesh/boundary_problem.h"
#include "core/mesh/tet_mesh.h"
#include "reference/door/adapter.h"

namespace palpate::reference {

/// The problem as JSON (palpate/problem/1):
///
///   {"schema": "palpate/problem/1", "strain": "small" | "large",
///    "material": {"young_modulus_pa": 10000.0, "poisson_ratio": 0.25, "density_kg_m3": 1050.0},
///    "gravity_m_s2": [0, 0, -9.81],
///    "held": [{"faces": [[a, b, c], ...], "axes": [true, true, true], "by_m": [0, 0, 0]}],
///    "supports": [{"faces": [...], "weight": [...], "stiffness_pa_per_m": 1e6, "by_m": [0, 0, 0]}],
///    "tractions": [{"faces": [...], "weight": [...], "traction_pa": [0, 0, -100], "pressure_pa": 0}],
///    "nodal_forces": [{"vertex": 7, "force_n": [0, 0, -0.1]}],
///    "body_force_n_m3": [[0, 0, -100], ...], "held_field_m": [[0, 0, 0.001], ...]}
///
/// The last two hold one vector a vertex and one an edge midpoint, in the order of the displacement's rows,
/// and are left out where they are empty.
nlohmann::json problem_to_json(const BoundaryProblem& problem);

/// Reads it back and checks it against the mesh: indices, finite numbers, weights in (0, 1], E > 0, density
/// >= 0, -1 < nu < 0.5, faces that are boundary faces of the mesh, nothing held in two ways. Throws:
/// InputError that starts with `where`.
BoundaryProblem problem_from_json(const nlohmann::json& json, const TetMesh& mesh, const std::string& where);

/// What a request of the contest deform asks: the mesh in metres, positively oriented, and its problem.
struct DeformTask {
  TetMesh mesh;
  BoundaryProblem problem;
};

/// Reads both files of a request. Throws: InputError, also for a request of another contest.
DeformTask read_deform_task(const Request& request);

/// A displacement as CSV: "vertex,ux_m,uy_m,uz_m", one row a vertex of the mesh, in order. A contestant with
/// quadratic shape functions adds one row for the midpoint of each edge of build_edges(mesh), in that order,
/// numbered on.
void write_displacement(const std::filesystem::path& path, std::span<const Vec3> displacement_m);

/// Reads it. Throws: InputError unless it has `rows_vertices` rows or `rows_vertices + rows_edges` rows of
/// finite numbers, in order.
std::vector<Vec3> read_displacement(const std::filesystem::path& path, std::size_t rows_vertices,
                                    std::size_t rows_edges);

}  // namespace palpate::reference

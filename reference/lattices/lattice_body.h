// A body as a lattice: what a request asks for, and what is made of it.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "core/dynamics/elasticity/elastic_model.h"
#include "core/dynamics/linear_algebra/block_matrix.h"
#include "core/mesh/boundary_problem.h"
#include "core/mesh/tet_mesh.h"
#include "core/springs/lattice/embedding.h"
#include "core/springs/lattice/lattice.h"
#include "core/springs/lattice/lattice_network.h"

namespace palpate::reference {

/// The options of lattice.* and moving_lattice.* alike.
struct LatticeRequest {
  springs::LatticeOptions lattice;
  springs::LatticeMix mix{0.0, 0.1};
  bool has_volume_energy = false;
  double held_stiffness = 100.0;  ///< of held faces, in E / spacing
};

/// Takes them out of `left`. `method` is "hexahedral" or "bcc" behind `prefix`. Throws: InputError.
LatticeRequest take_lattice_request(const std::string& prefix, const std::string& method,
                                    nlohmann::json& left);

/// A lattice, its elastic model over its own nodes, and where the vertices of the mesh are in it.
struct LatticeBody {
  springs::Lattice lattice;
  dynamics::ElasticModel elastic;
  springs::Embedding vertices;
  double held_pa_per_m = 0.0;  ///< penalty of held faces
  std::size_t half_axes = 0;
};

/// Builds the lattice and its springs:
///
///   without a volume energy  springs of the material's E; Poisson's ratio is 1/4 whatever the material's is
///   with one                 springs of 2.5 mu, and 1/2 (lambda - mu) V (tr eps)^2 of each cell, eps the
///   mean strain of
///                            its corners' trilinear field and V its share of the volume
///
/// Throws: InputError for large strain, a Poisson's ratio below 1/4 with the volume energy (lambda < mu: the
/// energy could be negative), or as build_lattice.
LatticeBody build_lattice_body(const TetMesh& mesh, const BoundaryProblem& problem,
                               const LatticeRequest& request);

/// The zero matrix whose pattern holds springs, cells and whatever is embedded in one cell.
dynamics::BlockMatrix build_lattice_pattern(const LatticeBody& body);

/// Counts of the lattice, its spacing and volume, and how far vertices lie beyond it.
void report_lattice(const LatticeBody& body, nlohmann::json& report);

/// What to say about a material that the model does not follow; empty for none.
std::string material_note(const Material& material, const LatticeRequest& request);

}  // namespace palpate::reference

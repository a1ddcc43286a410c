// The response of a free elastic body to tractions on its skin, as one table.
#pragma once

#include <cstdint>
#include <vector>

#include "core/dynamics/linear_algebra/sparse_factor.h"
#include "core/dynamics/reduced/skin_space.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::dynamics {

/// What a table is made of.
struct ComplianceOptions {
  int element_order = 2;   ///< 1 or 2
  int refine = 0;          ///< 0 or 1: elements on the mesh, or on its uniform refinement
  int reaction_order = 1;  ///< tractions on the mesh's faces are continuous and linear (1) or quadratic (2)
  double poisson_ratio = 0.25;
  bool midpoints = false;  ///< rows of field for the midpoints of the mesh's edges too
};

/// The compliance of the body that floats free, for Young's modulus 1 Pa.
///
/// A force q on the skin's nodes stands for the continuous traction t on its faces with M t = q, M the mass
/// of its linear (quadratic) shape functions psi. It is balanced by inertia: by rigid body forces that take
/// its resultant and its moment away. The body's answer, free of rigid motion (R^T M u = 0), is
///
///   at the skin, in the mean that works with q (the projection of u on the psi):  skin q
///   at the mesh's vertices, those of the skin first, then the others:             field q
///
/// When all forces together are in equilibrium the balances cancel, weight included, since it is a rigid body
/// force; the displacement is then field q / E + a rigid motion. So one table serves any supports.
///
/// Shape:  numbers are stored by rows; skin is 3 n x 3 n and symmetric, n = nodes.size(); field is 3 V x 3 n.
///         Component i of node k is 3 k + i. Values in m/N at 1 Pa. Either the double or the single arrays
///         are filled.
struct ComplianceTable {
  ComplianceOptions options;
  std::uint64_t body = 0;  ///< hash_body() of the mesh
  SkinNodes nodes;
  /// The mesh's vertices in the order of the rows of field: those of the skin, the others, then midpoints,
  /// if they were asked for: that of edge i of build_edges is V + i.
  std::vector<Index> order;
  std::vector<double> skin;
  std::vector<double> field;
  std::vector<float> skin_single;
  std::vector<float> field_single;

  bool is_single() const { return !skin_single.empty(); }
  std::size_t skin_bytes() const { return skin.size() * 8 + skin_single.size() * 4; }
  std::size_t field_bytes() const { return field.size() * 8 + field_single.size() * 4; }
};

/// What making it took.
struct ComplianceSetup {
  std::size_t unknowns = 0;
  std::size_t factor_entries = 0;
  double assembly_s = 0.0;
  double factor_s = 0.0;
  double solve_s = 0.0;
};

/// A number for the points and tetrahedra of a mesh (FNV-1a over their bytes).
std::uint64_t hash_body(const TetMesh& mesh);

/// Makes the table: one factorisation of the body pinned at six components (which then carry no force) and
/// three solves a node of the skin, in blocks.
///
/// Throws: InputError for options that don't fit, a mesh that is not one connected body, or a table of more
///         than 4 GiB; what `make_factor` throws.
/// Source: M. Bro-Nielsen and S. Cotin, Computer Graphics Forum 15 (1996), 57-66 (condensation to the skin);
///         D. L. James and D. K. Pai, SIGGRAPH 1999, 65-72 (compliance of a boundary, updates for contacts);
///         Klimenko 2003 (a precomputed response in a simulator).
ComplianceTable build_compliance_table(const TetMesh& mesh, const ComplianceOptions& options,
                                       const FactorMaker& make_factor, ComplianceSetup& setup);

/// The same table in single precision.
ComplianceTable to_single(const ComplianceTable& table);

}  // namespace palpate::dynamics

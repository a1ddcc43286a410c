// The judge: is this mesh valid, is its skin the input's, and how good are its tets? It shares the mesh
// struct and the base types with those it judges, and nothing else: predicates, volumes, qualities and
// topology are its own.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/mesh/tet_mesh.h"

namespace palpate::judge {

/// Counts of what is wrong with a mesh; all zero for a valid one.
struct Validity {
  std::uint64_t index_errors = 0;  ///< tets with an index out of range or a vertex twice
  std::uint64_t non_finite_points = 0;
  std::uint64_t inverted_tets = 0;         ///< exact orientation negative
  std::uint64_t flat_tets = 0;             ///< exact orientation zero
  std::uint64_t duplicate_tets = 0;        ///< same four vertices as an earlier tet
  std::uint64_t nonmanifold_faces = 0;     ///< more than two tets
  std::uint64_t folded_faces = 0;          ///< two tets on the same side
  std::uint64_t nonmanifold_edges = 0;     ///< link neither one circle nor one path
  std::uint64_t nonmanifold_vertices = 0;  ///< link neither a sphere nor a disc
  std::uint64_t isolated_vertices = 0;
  std::vector<std::string> findings;  ///< the first few of each kind, named by element number

  bool is_valid() const;
};

/// Sizes, and Euler's formulas of the thesis (A.1 on the boundary surface, A.2, A.3).
struct Counts {
  std::uint64_t vertices = 0;  ///< used by a tet
  std::uint64_t edges = 0;
  std::uint64_t faces = 0;
  std::uint64_t tets = 0;
  std::uint64_t boundary_vertices = 0;
  std::uint64_t boundary_edges = 0;
  std::uint64_t boundary_faces = 0;
  std::uint64_t components = 0;  ///< of tets joined by faces
  std::uint64_t boundary_components = 0;
  std::int64_t euler = 0;           ///< V - E + F - T; 1 for a ball (A.2)
  std::int64_t boundary_euler = 0;  ///< V - E + F of the boundary surface; 2 a sphere (A.1)
  bool formula_a1 = false;          ///< boundary: V - E + F = 2 (components - handles), consistent with euler
  bool formula_a2 = false;          ///< euler = 1
  bool formula_a3 = false;          ///< V - 3 <= T <= C(V - 1, 2) - n_hull + 2, n_hull >= 4
};

/// Shape of the tets, by the thesis's quality factor (2.3.5) and by angles.
struct Quality {
  double volume = 0.0;
  double ideal_volume = 0.0;                  ///< volume / tets
  std::array<std::uint64_t, 10> histogram{};  ///< 10 equal buckets on [0, 1]; above 1 counts in the last
  double percent_above_0_5 = 0.0;
  double percent_above_0_6 = 0.0;
  double mean_quality = 0.0;
  double min_quality = 0.0;
  double min_dihedral_deg = 0.0;
  double p1_dihedral_deg = 0.0;  ///< 1st percentile of the tets' least dihedral angles
  double max_dihedral_deg = 0.0;
};

/// What became of the input.
struct Comparison {
  std::uint64_t boundary_missing_faces =
      0;  ///< input boundary faces that the output lacks, by coordinates, to the bit
  std::uint64_t boundary_new_faces = 0;
  std::uint64_t boundary_changed_faces = 0;  ///< the sum of the two
  double volume_drift_relative = 0.0;
  bool euler_unchanged = false;
  bool components_unchanged = false;
};

Validity check_validity(const TetMesh& mesh);
Counts count_elements(const TetMesh& mesh);

/// Quality with the mesh's own ideal volume, or with `ideal_volume` > 0 (the input's). A tet that is not
/// positive has quality 0. Requires valid indices.
Quality measure_quality(const TetMesh& mesh, double ideal_volume = 0.0);

Comparison compare_with_input(const TetMesh& output, const TetMesh& input);

}  // namespace palpate::judge

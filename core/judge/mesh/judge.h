// The judge: is this mesh valid, is its skin the input's, and how good are its tets? It shares the mesh
// struct and the base types with those it judges, and nothing else: predicates, volumes, qualities and
// topology are its own. docs/judge.md has the definitions at length.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/mesh/tet_mesh.h"

namespace palpate::judge {

/// Counts of what is wrong with a mesh; all zero for a valid one.
struct Validity {
  std::uint64_t index_errors = 0;          ///< tets with an index out of range or a vertex twice
  std::uint64_t non_finite_points = 0;     ///< points with a coordinate that is NaN or infinite
  std::uint64_t inverted_tets = 0;         ///< exact orientation negative
  std::uint64_t flat_tets = 0;             ///< exact orientation zero
  std::uint64_t duplicate_tets = 0;        ///< same four vertices as an earlier tet
  std::uint64_t nonmanifold_faces = 0;     ///< more than two tets
  std::uint64_t folded_faces = 0;          ///< two tets, neither flat, with their apexes on the same side
  std::uint64_t nonmanifold_edges = 0;     ///< link neither one cycle nor one path: the tets around it make
                                           ///< neither one ring nor one fan
  std::uint64_t nonmanifold_vertices = 0;  ///< link neither a sphere nor a disc
  std::uint64_t isolated_vertices = 0;     ///< points that no tet with valid indices uses
  std::vector<std::string> findings;  ///< the first three of each kind, one line each; elements are counted
                                      ///< from 1, as in a .mesh file

  /// Whether every count is zero.
  bool is_valid() const;
};

/// Sizes, and Euler's formulas of the thesis (appendix A). Tets with invalid indices are left out.
struct Counts {
  std::uint64_t vertices = 0;  ///< used by a tet
  std::uint64_t edges = 0;
  std::uint64_t faces = 0;
  std::uint64_t tets = 0;
  std::uint64_t boundary_vertices = 0;
  std::uint64_t boundary_edges = 0;
  std::uint64_t boundary_faces = 0;       ///< faces with one tet
  std::uint64_t components = 0;           ///< of tets joined by faces
  std::uint64_t boundary_components = 0;  ///< of boundary faces joined by vertices
  std::int64_t euler = 0;           ///< V - E + F - T; 1 for a ball; a handle takes 1 away, a cavity adds 1
  std::int64_t boundary_euler = 0;  ///< V - E + F of the boundary surface; 2 for a sphere
  bool euler_consistent = false;    ///< boundary_euler = 2 euler, which holds for every 3-manifold
  bool formula_a1 = false;  ///< the boundary is one surface with V - E + F = 2: one polyhedron, no handle
  bool formula_a2 = false;  ///< euler = 1
  bool formula_a3 = false;  ///< V - 3 <= T <= C(V - 1, 2) - n + 2 with n the boundary vertices. n is at least
                            ///< the thesis's n_hull, so this implies A.3; A.2 proves it for every ball
};

/// A figure of the tets over all of them. The p-th percentile is that of nearest rank: the ceil(p n / 100)-th
/// smallest of the n figures.
struct Spread {
  double mean = 0.0;
  double p5 = 0.0;  ///< 5th percentile
  double p1 = 0.0;  ///< 1st percentile
  double least = 0.0;
};

/// Shape of the tets, by the thesis's quality factor (2.3.5), by interior dihedral angles, and by ratios that
/// are 1 for a regular tet alone (edge_ratio: for equal edges). Of these palpate.refined raises the mean
/// ratio.
///
///   q = cbrt(q1 q2 q3);  q1 = least solid angle / 0.55 sr,  q2 = shortest / longest edge,
///   q3 = min(1, V / ideal volume)
///
///   mean ratio = 12 (3 V)^(2/3) / sum of the squared edges,  radius ratio = 3 inradius / circumradius,
///   edge ratio = shortest / longest edge
///
/// A tet that is not positive (inverted, flat, or with a point that is not finite) has q and all ratios 0, a
/// least dihedral angle of 0 and a greatest of 180 degrees. If the ideal volume is not positive, every q is
/// 0. Nothing is ever NaN; a mesh without tets has zeros throughout.
struct Quality {
  double volume = 0.0;                        ///< sum of the signed volumes, in the mesh's own unit cubed
  double ideal_volume = 0.0;                  ///< the one that q3 used: volume / tets, or the one given
  std::array<std::uint64_t, 10> histogram{};  ///< 10 equal buckets on [0, 1], floor(10 q); q > 1 in the last
  double percent_above_0_5 = 0.0;             ///< of the tets, q > 0.5
  double percent_above_0_6 = 0.0;             ///< of the tets, q > 0.6
  double mean_quality = 0.0;
  double min_quality = 0.0;
  double min_dihedral_deg = 0.0;
  double p1_dihedral_deg = 0.0;  ///< 1st percentile of the tets' least dihedral angles
  double p5_dihedral_deg = 0.0;  ///< 5th percentile of the same
  double max_dihedral_deg = 0.0;
  double p99_max_dihedral_deg = 0.0;  ///< 99th percentile of the tets' greatest dihedral angles
  double p95_max_dihedral_deg = 0.0;  ///< 95th percentile of the same
  Spread mean_ratio;
  Spread radius_ratio;
  Spread edge_ratio;
};

/// What became of the input.
struct Comparison {
  std::uint64_t boundary_missing_faces = 0;  ///< input boundary faces that the output lacks, by coordinates,
                                             ///< to the bit (-0.0 is not 0.0), and by orientation
  std::uint64_t boundary_new_faces = 0;      ///< output boundary faces that the input lacks
  std::uint64_t boundary_changed_faces = 0;  ///< the sum of the two
  double volume_drift_relative = 0.0;        ///< |V_out - V_in| / |V_in|; 1 if V_in is zero and V_out is not
  bool euler_unchanged = false;              ///< of the mesh and of its boundary
  bool components_unchanged = false;         ///< of the mesh and of its boundary
};

/// A part of space whose tets had to be left alone. Lengths in the mesh's own unit.
struct Region {
  enum class Kind {
    kSphere,       ///< |x - vector| <= size
    kHalfSpace,    ///< vector . x <= size
    kSurfacePatch  ///< within `depth` of the input's boundary faces with a vertex v, |v - vector| <= size
  };
  Kind kind = Kind::kSphere;
  Vec3 vector;
  double size = 0.0;
  double depth = 0.0;
};

/// What became of the tets in regions. Those count that certainly meet one: that come nearer than its border
/// by 2^-40 of the largest coordinate, or, in a patch of depth 0, share a vertex with a face of it.
struct RegionFigures {
  std::uint64_t input_tets = 0;  ///< of the input that meet a region
  std::uint64_t changed_tets =
      0;  ///< of these, not in the output: by coordinates, to the bit, and orientation
  std::uint64_t output_tets = 0;  ///< of the output that meet a region
};

/// Checks a mesh, whatever its arrays hold. A tet with invalid indices is counted and left out of everything
/// else; one with a non-finite point has no orientation, but its faces, edges and vertices are checked.
/// Time:    n log n in the tets of one vertex star, otherwise linear.
/// Memory:  about 20 bytes a tet and 12 a vertex beside the mesh.
Validity check_validity(const TetMesh& mesh);

/// Counts elements, components and Euler characteristics. Never fails; time and memory as check_validity().
Counts count_elements(const TetMesh& mesh);

/// Quality with the mesh's own ideal volume (`ideal_volume` 0), or with one that is given, as the input's.
/// Time and memory: linear, 56 bytes a tet.
/// Throws: ContractError if a tet has invalid indices, or if the ideal volume is negative or not finite.
Quality measure_quality(const TetMesh& mesh, double ideal_volume = 0.0);

/// Compares the boundary faces as oriented triples of points, each point by the bit patterns of its
/// coordinates; vertex numbers don't matter. Tets with invalid indices are left out of both meshes.
Comparison compare_with_input(const TetMesh& output, const TetMesh& input);

/// Counts the tets in regions, and those of the input that the output lacks. All zero without regions. Tets
/// with invalid indices are left out.
///
/// A tet meets a ball or the neighbourhood of a triangle if the smallest vector of the set of differences
/// {p - q : p in the tet, q in the triangle (or the center)} is short enough. Frank and Wolfe's steps bound
/// it from above by the point they are at and from below by the plane that supports the set there; the few
/// tets that 1000 steps cannot decide touch the border, and don't count.
/// Source: Frank and Wolfe, Naval Res. Logist. Q. 3 (1956); Gilbert, SIAM J. Control 4 (1966).
RegionFigures compare_in_regions(const TetMesh& output, const TetMesh& input,
                                 std::span<const Region> regions);

}  // namespace palpate::judge

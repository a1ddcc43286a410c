// How far a displacement is from a reference at some of a mesh's vertices alone.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/base/types.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::judge {

/// The vertices at which an error is asked for, each once, and what each counts.
///
/// Shape:  one weight > 0 a vertex.
struct ChosenPoints {
  std::vector<std::size_t> vertex;
  std::vector<double> weight;
};

/// How large a field is there. `deformation` is of the field less the best rigid motion of the whole body,
/// weighted by volume: a place by itself has none that could be told from its strain.
struct ChosenSize {
  double l2 = 0.0;           ///< sqrt(sum w |u|^2 / sum w), in m
  double deformation = 0.0;  ///< the same of u less that motion, in m
  double max = 0.0;          ///< max |u|, in m
};

/// Measures a field that has one row a vertex; rows beyond the vertices are left out. Throws: ContractError
/// for no vertex, one that does not exist, other sizes, or a weight that is not above zero.
ChosenSize measure_chosen(const TetMesh& mesh, std::span<const Vec3> field, const ChosenPoints& chosen);

/// Errors at the chosen vertices, over what the reference has there.
struct ChosenError {
  double relative_l2 = 0.0;           ///< |u - r| / |r|
  double relative_deformation = 0.0;  ///< the same less the whole body's best rigid motion, each its own
  double relative_max = 0.0;          ///< max |u - r| / max |r|
};

/// Compares two fields of one row a vertex. Throws: as measure_chosen; InputError for a field that is not
/// finite, or a reference that does not move, or does not deform, where it is asked for.
ChosenError compare_chosen(const TetMesh& mesh, std::span<const Vec3> field, std::span<const Vec3> truth,
                           const ChosenPoints& chosen);

}  // namespace palpate::judge

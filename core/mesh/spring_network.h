// A network of springs over the vertices of a mesh, as plain arrays: what identification writes and dynamics
// reads.
#pragma once

#include <vector>

#include "core/base/types.h"

namespace palpate {

/// Linear springs between vertices.
///
/// Shape:  one entry a spring in each array; springs[i] = {a, b} with a < b, sorted, each pair once. Edges
///         of the mesh, or also pairs of opposite apexes (face_opposite). Lengths in m, stiffness in N/m,
///         >= 0. A spring of stiffness zero stays in the list.
struct SpringNetwork {
  std::vector<Edge> springs;
  std::vector<double> rest_length_m;
  std::vector<double> stiffness_n_per_m;

  friend bool operator==(const SpringNetwork&, const SpringNetwork&) = default;
};

}  // namespace palpate

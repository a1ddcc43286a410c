// A field that varies as problems give it: values at vertices and edge midpoints, quadratic in each tet.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/mesh/subdivision/refinement.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::reference {

/// Evaluates such a field; one without values is zero.
class QuadraticField {
 public:
  /// `mesh` and `values` outlive it.
  QuadraticField(const TetMesh& mesh, const std::vector<Vec3>& values) : mesh_(mesh), values_(values) {
    if (!values.empty()) edges_ = build_edge_numbers(mesh);
  }

  /// sum over corners of l_i (2 l_i - 1) v_i + sum over edges of 4 l_i l_j v_ij, at barycentric coordinates
  /// l.
  Vec3 at(std::size_t tet, const std::array<double, 4>& l) const {
    Vec3 sum;
    if (values_.empty()) return sum;
    const Tet& t = mesh_.tets[tet];
    for (std::size_t i = 0; i < 4; ++i) {
      if (l[i] == 0.0) continue;
      sum = sum + (l[i] * (2.0 * l[i] - 1.0)) * values_[t[i]];
      for (std::size_t j = i + 1; j < 4; ++j) {
        if (l[j] == 0.0) continue;
        sum = sum + (4.0 * l[i] * l[j]) * values_[mesh_.points.size() + edges_.of(t[i], t[j])];
      }
    }
    return sum;
  }

 private:
  const TetMesh& mesh_;
  const std::vector<Vec3>& values_;
  EdgeNumbers edges_;
};

}  // namespace palpate::reference

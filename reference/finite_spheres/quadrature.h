// Rules of integration over tets and faces, in barycentric coordinates, and fields that vary over them.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/mesh/subdivision/refinement.h"
#include "core/mesh/tet_mesh.h"
#include "core/mesh/triangle_rule.h"

namespace palpate::reference {

/// A point of a rule over a tet, with its share of the volume; the shares sum to 1.
struct TetPoint {
  std::array<double, 4> at{};
  double weight = 0.0;
};

/// Gauss points over a tet, all inside and with positive weights: 1, 4 or 14 of them are exact for
/// polynomials of degree 1, 2 or 5. `subdivide` times the tet is split into eight equal parts with a rule of
/// their own each. (The rule of 11 points and degree 4 has a negative weight: a stiffness that it integrates
/// can be indefinite.) Throws: InputError for another count. Sources: P. Keast, Comput. Methods Appl. Mech.
/// Engrg. 55 (1986), 339-348; N. J. Walkington, Quadrature on simplices of arbitrary dimension (2000), 14
/// points.
std::vector<TetPoint> build_tet_rule(int points, int subdivide);

/// build_radon_rule over a face (degree 5); `subdivide` as above, into four.
std::vector<FacePoint> build_face_rule(int subdivide);

/// The middles of the six parts into which the medians cut a face, two at each corner: exact for degree 1 on
/// the part of each corner, which bounds its dual cell.
std::vector<FacePoint> build_dual_face_rule();

/// The corner whose dual cell point i of build_dual_face_rule bounds.
inline constexpr std::array<int, 6> kDualFaceCorner{0, 0, 1, 1, 2, 2};

/// Evaluates a field that varies as problems give it: values at vertices and edge midpoints, quadratic in
/// each tet; one without values is zero.
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

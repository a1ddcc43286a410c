// How fast a vertex of a mesh swings with its neighbours held: what the longest stable step hangs on.
#pragma once

#include <array>

#include "core/simplify/tet_operations/working_mesh.h"

namespace palpate::simplify {

/// A vertex with its neighbours held: K_vv, the stiffness that its tets (linear elements) put against its own
/// displacement, and its lumped mass, a quarter of its tets'.
///
///   K_vv / mu = (lambda + mu) / mu S + tr(S) I,   S = sum over the tets of V grad grad^T
///   rate = largest eigenvalue of K_vv / mu / sum of V / 4,   in 1 / length^2
///
/// at Poisson's ratio 0.3. grad is the gradient of the vertex's shape function, one over the altitude long.
/// rate mu / rho is a Rayleigh quotient, so a lower bound of the square of the body's greatest frequency;
/// where few vertices have great rates the step is within a tenth of what they say, where all are equal
/// within a quarter.
struct VertexRate {
  std::array<double, 6> stiffness{};  ///< S: xx, yy, zz, xy, xz, yz
  double volume = 0.0;                ///< of its tets

  void add(const Vec3& gradient, double tet_volume, double sign);
  /// The rate; 0 without tets.
  double rate() const;
};

/// lambda / mu at Poisson's ratio 0.3.
inline constexpr double kLamePerShear = 1.5;

/// The shape functions of a tet.
struct ShapeGradients {
  double six_volumes = 0.0;       ///< below 0 for a tet that is turned over
  std::array<Vec3, 4> at_corner;  ///< one a corner
};

/// Of the tet (p, a, b, c). All is 0 for a flat one.
ShapeGradients gradients_of_tet(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

/// Adds the tet (p, base) to the rates of its four vertices, or takes it away (sign -1). The gradient of a
/// vertex's shape function is the normal of the face opposite over six volumes.
void add_tet(const Vec3& p, const std::array<const Vec3*, 3>& base, const std::array<VertexRate*, 4>& to,
             double sign);

/// The rate of vertex v of a mesh. Requires: positive tets.
VertexRate measure_vertex(const WorkingMesh& mesh, Index v);

/// The greatest rate of a mesh's vertices; 0 without tets. Requires: positive tets.
double greatest_rate(const TetMesh& mesh);

}  // namespace palpate::simplify

// The conditions that make a spring network an isotropic solid, as least-squares rows at each vertex.
//
// At vertex n with springs of unit direction e (away from n), rest length U and w = k U^2, and with V_n a
// quarter of the volume of its tets, a network is isotropic with Young's modulus E (Poisson's ratio 1/4) when
//
//   sum w e(x)e(x)e(x)e = 12 E V_n <e(x)e(x)e(x)e>                                (isotropy, 15 rows)
//
// with <...> the mean over the sphere, and it hands on an affine field's traction when
//
//   sum k U e(x)e(x)e = -mu (d_jk A_i + d_ij A_k + d_ik A_j),  mu = E / 2.5,       (patch, 10 rows)
//
// with A a third of the area vectors of the boundary faces at n, 0 inside. Both are weighted so that the sum
// of squares is the Frobenius norm of the tensors: turning the mesh changes nothing. The patch rows are
// multiplied by `patch_length` times the mean rest length at n, which makes them moments, as the others are.
// Source: thesis eqs. 3.15-3.17, corrected (docs/errata.md); the patch rows are ours.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/mesh/tet_mesh.h"
#include "core/springs/solvers/nonnegative_least_squares.h"

namespace palpate::springs {

/// Rows a vertex: monomials of degree 4 in three variables.
inline constexpr std::size_t kIsotropyRows = 15;
/// Rows a vertex: monomials of degree 3.
inline constexpr std::size_t kPatchRows = 10;

/// Coefficients of one spring in the isotropy rows of its end: sqrt(4! / (i! j! k!)) x^i y^j z^k, i + j + k =
/// 4, for its unit direction (x, y, z). The rows of two springs have the inner product (e . f)^4.
std::array<double, kIsotropyRows> isotropy_coefficients(const Vec3& direction);

/// The mean of isotropy_coefficients over the sphere: 1/5 for x^4, sqrt(6)/15 for x^2 y^2, else 0.
std::array<double, kIsotropyRows> isotropy_means();

/// Coefficients of one spring in the patch rows: sqrt(3! / (i! j! k!)) x^i y^j z^k, i + j + k = 3. Inner
/// product (e . f)^3.
std::array<double, kPatchRows> patch_coefficients(const Vec3& direction);

/// The tensor (d_jk A_i + d_ij A_k + d_ik A_j) in the patch rows' coordinates.
std::array<double, kPatchRows> patch_target(const Vec3& area);

/// Which rows, with which weights.
struct IsotropyOptions {
  bool patch = false;         ///< also the patch rows
  double patch_length = 1.0;  ///< weight of the patch rows, in mean rest lengths at the vertex
  NonnegativeOptions solve;   ///< `toward` and the ridge act on w = k U^2
};

}  // namespace palpate::springs

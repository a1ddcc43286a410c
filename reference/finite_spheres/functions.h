// The shape functions of the spheres: rational, with a partition of unity, exact for linear fields.
#pragma once

#include <cstddef>
#include <vector>

#include "core/base/enum_names.h"
#include "reference/finite_spheres/spheres.h"

namespace palpate::reference {

/// kLeastSquares: moving least squares of first order, one function a sphere. kShepard: Shepard's partition
/// of unity times 1, x, y, z, four functions a sphere, as in the method of finite spheres.
enum class SphereFunctions { kLeastSquares, kShepard };

/// By the option `functions`.
inline constexpr EnumNames<SphereFunctions, 2> kSphereFunctionNames{"functions", {"mls", "shepard"}};

/// 1 or 4. Function n of sphere I has the number functions_per_sphere x I + n.
std::size_t functions_per_sphere(SphereFunctions kind);

/// The weight of a sphere at the share s of its radius: the quartic spline 1 - 6 s^2 + 8 s^3 - 3 s^4, 0 from
/// s = 1 on. Its first two derivatives vanish at s = 1.
double quartic_spline(double share);

/// The functions that are not zero at a point.
///
/// Shape:  one entry a function; numbers increase; gradients in 1/m.
struct FunctionValues {
  std::vector<Index> numbers;
  std::vector<double> values;
  std::vector<Vec3> gradients;
};

/// Evaluates the functions at a point of a tet, in m. With w_I the weight of sphere I, d_I = x_I - x, P_I =
/// (1, d_I):
///
///   mls:      phi_I = w_I P_I . b,  A b = (1, 0, 0, 0),  A = sum w_I P_I P_I^T
///   shepard:  h_I0 = w_I / sum w,  h_In = h_I0 (x - x_I)_n / r_I,  n = 1, 2, 3
///
/// The sum of phi_I u(x_I), and of h_I0 u(x_I) + r_I du/dx_n h_In, is u(x) for each linear u.
/// `out` is overwritten. Throws: InputError if the spheres at the point have their centres in one plane, to
/// rounding: a tet there is flat. Sources: S. De and K. J. Bathe, Computational Mechanics 25 (2000), 329-345
/// (spheres, Shepard); P. Lancaster and K. Salkauskas, Math. Comp. 37 (1981), 141-158 (moving least squares);
/// T. Belytschko et al., Comput. Methods Appl. Mech. Engrg. 139 (1996), 3-47 (quartic spline).
void evaluate_functions(const Spheres& spheres, SphereFunctions kind, std::size_t tet, const Vec3& at,
                        FunctionValues& out);

}  // namespace palpate::reference

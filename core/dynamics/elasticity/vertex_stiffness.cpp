#include "core/dynamics/elasticity/vertex_stiffness.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace palpate::dynamics {
namespace {

Mat3 corotated_block(const Moduli& moduli, const Mat3& h, const Vec3& g) {
  const Mat3 f = kIdentity + h;
  const Mat3 r = nearest_rotation(f);
  const Mat3 stretch_raw = multiply_transposed(r, f);
  const Mat3 stretch = 0.5 * (stretch_raw + transpose(stretch_raw));
  const Mat3 turned = trace(stretch) * kIdentity - stretch;
  const Vec3 rg = r * g;
  const double size_sq = length_sq(g);
  Mat3 block = (2.0 * moduli.mu_pa * size_sq) * kIdentity + moduli.lambda_pa * outer(rg, rg);
  const double det = determinant(turned);
  const double size = trace(turned);
  // Sums of two stretches: where one nearly vanishes the rotation is undefined, and its part is left out.
  constexpr double kVanishing = 1e-6;
  if (!(det > kVanishing * size * size * size)) return block;
  const Mat3 inverse = (1.0 / det) * cofactors(turned);
  const Mat3 spin = multiply(r, cross_matrix(g));
  // The part's largest eigenvalue is at most |inverse| |g|^2.
  const double most = 2.0 * moduli.mu_pa / std::sqrt(contract(inverse, inverse));
  const double twist = std::min(2.0 * moduli.mu_pa - moduli.lambda_pa * (trace(stretch) - 3.0), most);
  return block - twist * multiply(spin, multiply(inverse, transpose(spin)));
}

}  // namespace

Mat3 vertex_stiffness(StrainLaw law, const Moduli& moduli, const Mat3& h, const Vec3& gradient) {
  const double size_sq = length_sq(gradient);
  switch (law) {
    case StrainLaw::kLinear:
      return (moduli.mu_pa * size_sq) * kIdentity +
             std::max(moduli.mu_pa + moduli.lambda_pa, -moduli.mu_pa) * outer(gradient, gradient);
    case StrainLaw::kCorotated:
      return corotated_block(moduli, h, gradient);
    case StrainLaw::kNeoHookean: {
      const Mat3 f = kIdentity + h;
      const double det = determinant(f);
      const Vec3 w = (1.0 / det) * (cofactors(f) * gradient);
      const double along = moduli.mu_pa + moduli.lambda_pa - moduli.lambda_pa * std::log(det);
      return (moduli.mu_pa * size_sq) * kIdentity + std::max(along, 0.0) * outer(w, w);
    }
    case StrainLaw::kStableNeoHookean: {
      const Vec3 w = cofactors(kIdentity + h) * gradient;
      return (moduli.mu_pa * size_sq) * kIdentity +
             std::max(moduli.lambda_pa + moduli.mu_pa, 0.0) * outer(w, w);
    }
  }
  throw ContractError("vertex_stiffness: unknown law");
}

Mat3 vertex_damping(StrainLaw law, const Moduli& viscous, const Mat3& h, const Mat3& before,
                    const Vec3& gradient) {
  const double along = std::max(viscous.mu_pa + viscous.lambda_pa, -viscous.mu_pa);
  const Mat3 f = kIdentity + h;
  if (law == StrainLaw::kNeoHookean) {
    const Vec3 w = (1.0 / determinant(f)) * (cofactors(f) * gradient);
    return (viscous.mu_pa * length_sq(w)) * kIdentity + along * outer(w, w);
  }
  if (law == StrainLaw::kStableNeoHookean) {
    const Vec3 turned = f * gradient;
    const Mat3 change = h - before;
    const double size_sq = length_sq(gradient);
    const double pull = 2.0 * viscous.mu_pa * dot(turned, change * gradient) +
                        viscous.lambda_pa * contract(f, change) * size_sq;
    const double across = viscous.mu_pa * size_sq;
    Mat3 block = outer(along * turned, turned);
    for (std::size_t i = 0; i < 3; ++i) {
      block(i, i) += std::max(pull, 0.0);
      for (std::size_t j = 0; j <= i; ++j) {
        const double entry = across * dot(f.row(i), f.row(j));
        block(i, j) += entry;
        if (i != j) block(j, i) += entry;
      }
    }
    return block;
  }
  return vertex_stiffness(law, viscous, h, gradient);
}

}  // namespace palpate::dynamics

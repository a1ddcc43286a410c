#include "core/dynamics/elasticity/elastic_law.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/base/enum_names.h"
#include "core/base/error.h"

namespace palpate::dynamics {
namespace {

constexpr EnumNames<StrainLaw, 4> kLawNames{"law",
                                            {"linear", "corotated", "neo_hookean", "stable_neo_hookean"}};

/// det(I + h) - 1 without cancellation: tr h + sum of the principal minors + det h.
double volume_strain(const Mat3& h) {
  return trace(h) + trace(cofactors(h)) + determinant(h);
}

/// Higham's scaled Newton iteration X <- (g X + X^-T / g) / 2, which converges to the rotation of the polar
/// decomposition quadratically while det X > 0. Source: N. Higham, SIAM J. Sci. Stat. Comput. 7 (1986).
bool iterate_polar(Mat3& x) {
  constexpr int kMostSteps = 30;
  for (int step = 0; step < kMostSteps; ++step) {
    const double det = determinant(x);
    const double norm_sq = contract(x, x);
    if (!(det > 1e-12 * norm_sq * std::sqrt(norm_sq))) return false;
    const Mat3 inverse_transposed = (1.0 / det) * cofactors(x);
    const double inverse_sq = contract(inverse_transposed, inverse_transposed);
    // Scaling only helps far from the rotation; near it the plain step keeps the convergence quadratic.
    const bool is_near = norm_sq < 4.0 && inverse_sq < 4.0;
    const double scale = is_near ? 1.0 : std::sqrt(std::sqrt(inverse_sq / norm_sq));
    const Mat3 next = (0.5 * scale) * x + (0.5 / scale) * inverse_transposed;
    const Mat3 change = next - x;
    x = next;
    // The next change is about the square of this one.
    if (contract(change, change) < 1e-17) return true;
  }
  return true;
}

using Rows3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

/// U V^T of the singular vectors; the least singular value takes the sign of the determinant.
Mat3 rotate_by_singular_vectors(const Mat3& f) {
  const Eigen::JacobiSVD<Rows3> svd(Eigen::Map<const Rows3>(f.m.data()),
                                    Eigen::ComputeFullU | Eigen::ComputeFullV);
  Rows3 left = svd.matrixU();
  if (left.determinant() * svd.matrixV().determinant() < 0.0) left.col(2) *= -1.0;
  Mat3 rotation;
  Eigen::Map<Rows3>(rotation.m.data()) = left * svd.matrixV().transpose();
  return rotation;
}

/// R and the strain S - I = sym(R^T (F - R)).
struct Corotated {
  Mat3 rotation;
  Mat3 strain;
};

Corotated corotate(const Mat3& h) {
  const Mat3 f = kIdentity + h;
  const Mat3 r = nearest_rotation(f);
  const Mat3 e = multiply_transposed(r, f - r);
  return {r, 0.5 * (e + transpose(e))};
}

Mat3 inverse_symmetric(const Mat3& a) {
  const Eigen::SelfAdjointEigenSolver<Rows3> eigen(Eigen::Map<const Rows3>(a.m.data()));
  const double largest =
      std::max(eigen.eigenvalues().cwiseAbs().maxCoeff(), std::numeric_limits<double>::min());
  Mat3 inverse;
  for (Eigen::Index k = 0; k < 3; ++k) {
    // Two opposite singular values leave the rotation undefined; the bound keeps the derivative finite.
    const double found = eigen.eigenvalues()[k];
    const double value = std::copysign(std::max(std::abs(found), 1e-9 * largest), found);
    const Vec3 v{eigen.eigenvectors()(0, k), eigen.eigenvectors()(1, k), eigen.eigenvectors()(2, k)};
    inverse += (1.0 / value) * outer(v, v);
  }
  return inverse;
}

/// dP = 2 mu dF + (lambda tr E - 2 mu) dR + lambda (R : dF) R, with dR = R [w]x, (tr S I - S) w = axial of
/// R^T dF - dF^T R. For dF = e_i e_j^T that axial vector is e_j x (row i of R).
Tangent9 corotated_tangent(const Moduli& moduli, const Mat3& h) {
  const Corotated c = corotate(h);
  const Mat3 stretch = kIdentity + c.strain;
  const Mat3 inverse = inverse_symmetric(trace(stretch) * kIdentity - stretch);
  const double twist = moduli.lambda_pa * trace(c.strain) - 2.0 * moduli.mu_pa;
  constexpr std::array<Vec3, 3> kAxes{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
  std::array<Vec3, 9> axial;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) axial[3 * i + j] = cross(kAxes[j], c.rotation.row(i));
  }
  Tangent9 out{};
  for (std::size_t a = 0; a < 9; ++a) {
    const Vec3 turned = inverse * axial[a];
    for (std::size_t b = 0; b < 9; ++b) {
      out[9 * a + b] = twist * dot(turned, axial[b]) + moduli.lambda_pa * c.rotation.m[a] * c.rotation.m[b];
    }
    out[9 * a + a] += 2.0 * moduli.mu_pa;
  }
  return out;
}

/// dP = mu dF + (mu - lambda ln J) G dF^T G + lambda (G : dF) G, G = F^-T.
Tangent9 neo_hookean_tangent(const Moduli& moduli, const Mat3& h) {
  const Mat3 f = kIdentity + h;
  const Mat3 g = (1.0 / determinant(f)) * cofactors(f);
  const double shear = moduli.mu_pa - moduli.lambda_pa * std::log1p(volume_strain(h));
  Tangent9 out{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t l = 0; l < 3; ++l) {
          out[9 * (3 * i + j) + 3 * k + l] = shear * g(i, l) * g(k, j) + moduli.lambda_pa * g(i, j) * g(k, l);
        }
      }
      out[10 * (3 * i + j)] += moduli.mu_pa;
    }
  }
  return out;
}

/// mu (H + H^T - tr H I - cof H) + (lambda + mu) (J - 1) cof F, cof F = (1 + tr H) I - H^T + cof H.
Mat3 stable_stress(const Moduli& moduli, const Mat3& h) {
  const Mat3 minors = cofactors(h);
  const Mat3 shear = h + transpose(h) - trace(h) * kIdentity - minors;
  const double pressure = (moduli.lambda_pa + moduli.mu_pa) * volume_strain(h);
  return moduli.mu_pa * shear + pressure * ((1.0 + trace(h)) * kIdentity - transpose(h) + minors);
}

/// dP = mu dF + ((lambda + mu) (J - 1) - mu) dcof F + (lambda + mu) (cof F : dF) cof F,
/// dcof F_ij / dF_kl = e_ikm e_jln F_mn.
Tangent9 stable_tangent(const Moduli& moduli, const Mat3& h) {
  const Mat3 f = kIdentity + h;
  const Mat3 cof = cofactors(f);
  const double bulk = moduli.lambda_pa + moduli.mu_pa;
  const double turning = bulk * volume_strain(h) - moduli.mu_pa;
  Tangent9 out{};
  for (std::size_t a = 0; a < 9; ++a) {
    for (std::size_t b = 0; b < 9; ++b) out[9 * a + b] = bulk * cof.m[a] * cof.m[b];
    out[10 * a] += moduli.mu_pa;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      // The minor of (i, j) is F(i+1, j+1) F(i+2, j+2) - F(i+1, j+2) F(i+2, j+1), indices modulo 3.
      const std::array<std::size_t, 2> rows{(i + 1) % 3, (i + 2) % 3};
      const std::array<std::size_t, 2> columns{(j + 1) % 3, (j + 2) % 3};
      for (std::size_t r = 0; r < 2; ++r) {
        for (std::size_t c = 0; c < 2; ++c) {
          const double sign = r == c ? 1.0 : -1.0;
          out[9 * (3 * i + j) + 3 * rows.at(r) + columns.at(c)] +=
              turning * sign * f(rows.at(1 - r), columns.at(1 - c));
        }
      }
    }
  }
  return out;
}

Tangent9 linear_tangent(const Moduli& moduli) {
  Tangent9 out{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      out[9 * (3 * i + j) + 3 * i + j] += moduli.mu_pa;
      out[9 * (3 * i + j) + 3 * j + i] += moduli.mu_pa;
      out[9 * (4 * i) + 4 * j] += moduli.lambda_pa;
    }
  }
  return out;
}

/// 2 mu d + lambda tr d I.
Mat3 viscous_stress(const Moduli& viscous, const Mat3& d) {
  return (2.0 * viscous.mu_pa) * d + (viscous.lambda_pa * trace(d)) * kIdentity;
}

Mat3 symmetric_part(const Mat3& a) {
  return 0.5 * (a + transpose(a));
}

/// The vector w with [w]x = a - a^T.
Vec3 axial_of(const Mat3& a) {
  return {a(2, 1) - a(1, 2), a(0, 2) - a(2, 0), a(1, 0) - a(0, 1)};
}

/// The rate of the right stretch U of one gradient F = Q U, as a linear map of dF/dt, and its transpose.
///
///   dU/dt = sym(B - [w]x U),  B = Q^T dF/dt,  G w = axial of B,  G = tr U I - U
class StretchRate {
 public:
  explicit StretchRate(const Mat3& h) {
    const Mat3 f = kIdentity + h;
    const bool is_mirrored = determinant(f) < 0.0;
    turn_ = is_mirrored ? (-1.0) * nearest_rotation((-1.0) * f) : nearest_rotation(f);
    stretch_ = symmetric_part(multiply_transposed(turn_, f));
    const Mat3 g = trace(stretch_) * kIdentity - stretch_;
    const double det = determinant(g);
    const double size = trace(g);
    // G has the sums of two stretches. Where two of them vanish, so does a sum: the turn is undefined.
    constexpr double kVanishing = 1e-9;
    constexpr double kNothing = 1e-200;
    if (det > kVanishing * size * size * size) {
      inverse_ = (1.0 / det) * cofactors(g);
    } else if (size > kNothing) {
      inverse_ = inverse_symmetric(g);
    }
  }

  Mat3 of(const Mat3& rate) const {
    const Mat3 b = multiply_transposed(turn_, rate);
    return symmetric_part(b - multiply(cross_matrix(inverse_ * axial_of(b)), stretch_));
  }

  /// The stress whose power with dF/dt is that of the symmetric `t` with dU/dt.
  Mat3 pull_back(const Mat3& t) const {
    return multiply(turn_, t - cross_matrix(inverse_ * axial_of(multiply(t, stretch_))));
  }

 private:
  Mat3 turn_;
  Mat3 stretch_;
  Mat3 inverse_;
};

/// Column by column from the stresses of unit rates.
template <typename StressOf>
Tangent9 tabulate(const StressOf& stress_of) {
  Tangent9 out{};
  for (std::size_t column = 0; column < 9; ++column) {
    Mat3 rate;
    rate.m[column] = 1.0;
    const Mat3 p = stress_of(rate);
    for (std::size_t row = 0; row < 9; ++row) out[9 * row + column] = p.m[row];
  }
  return out;
}

}  // namespace

StrainLaw parse_strain_law(std::string_view name) {
  return kLawNames.parse(name);
}

const char* strain_law_name(StrainLaw law) {
  return kLawNames.of(law);
}

Mat3 nearest_rotation(const Mat3& f) {
  Mat3 rotation = f;
  return iterate_polar(rotation) ? rotation : rotate_by_singular_vectors(f);
}

double energy_density(StrainLaw law, const Moduli& moduli, const Mat3& h) {
  if (law == StrainLaw::kNeoHookean) {
    const double dilatation = volume_strain(h);
    if (!(dilatation > -1.0)) return std::numeric_limits<double>::infinity();
    const double log_j = std::log1p(dilatation);
    return 0.5 * moduli.mu_pa * (2.0 * trace(h) + contract(h, h)) - moduli.mu_pa * log_j +
           0.5 * moduli.lambda_pa * log_j * log_j;
  }
  if (law == StrainLaw::kStableNeoHookean) {
    const double dilatation = volume_strain(h);
    // tr H cancels between I1 - 3 and 2 (J - 1).
    const double shear = contract(h, h) - 2.0 * (trace(cofactors(h)) + determinant(h));
    return 0.5 * moduli.mu_pa * shear + 0.5 * (moduli.lambda_pa + moduli.mu_pa) * dilatation * dilatation;
  }
  const Mat3 strain = law == StrainLaw::kLinear ? 0.5 * (h + transpose(h)) : corotate(h).strain;
  const double dilatation = trace(strain);
  return moduli.mu_pa * contract(strain, strain) + 0.5 * moduli.lambda_pa * dilatation * dilatation;
}

Mat3 stress(StrainLaw law, const Moduli& moduli, const Mat3& h) {
  if (law == StrainLaw::kNeoHookean) {
    const Mat3 f = kIdentity + h;
    const Mat3 g = (1.0 / determinant(f)) * cofactors(f);
    const double log_j = std::log1p(volume_strain(h));
    return moduli.mu_pa * (f - g) + (moduli.lambda_pa * log_j) * g;
  }
  if (law == StrainLaw::kStableNeoHookean) return stable_stress(moduli, h);
  if (law == StrainLaw::kLinear) {
    return moduli.mu_pa * (h + transpose(h)) + (moduli.lambda_pa * trace(h)) * kIdentity;
  }
  const Corotated c = corotate(h);
  return multiply(c.rotation,
                  (2.0 * moduli.mu_pa) * c.strain + (moduli.lambda_pa * trace(c.strain)) * kIdentity);
}

Mat3 damping_stress(StrainLaw law, const Moduli& viscous, const Mat3& h, const Mat3& rate) {
  if (law == StrainLaw::kLinear) return stress(StrainLaw::kLinear, viscous, rate);
  if (law == StrainLaw::kCorotated) {
    const StretchRate stretch(h);
    return stretch.pull_back(viscous_stress(viscous, stretch.of(rate)));
  }
  const Mat3 f = kIdentity + h;
  if (law == StrainLaw::kStableNeoHookean)
    return multiply(f, viscous_stress(viscous, symmetric_part(multiply_transposed(f, rate))));
  const Mat3 inverse_transposed = (1.0 / determinant(f)) * cofactors(f);
  const Mat3 d = symmetric_part(multiply(rate, transpose(inverse_transposed)));
  return multiply(viscous_stress(viscous, d), inverse_transposed);
}

Tangent9 damping_tangent(StrainLaw law, const Moduli& viscous, const Mat3& h) {
  if (law == StrainLaw::kLinear) return linear_tangent(viscous);
  if (law == StrainLaw::kNeoHookean || law == StrainLaw::kStableNeoHookean)
    return tabulate([&](const Mat3& rate) { return damping_stress(law, viscous, h, rate); });
  const StretchRate stretch(h);
  return tabulate(
      [&](const Mat3& rate) { return stretch.pull_back(viscous_stress(viscous, stretch.of(rate))); });
}

Tangent9 tangent(StrainLaw law, const Moduli& moduli, const Mat3& h) {
  switch (law) {
    case StrainLaw::kLinear:
      return linear_tangent(moduli);
    case StrainLaw::kCorotated:
      return corotated_tangent(moduli, h);
    case StrainLaw::kNeoHookean:
      return neo_hookean_tangent(moduli, h);
    case StrainLaw::kStableNeoHookean:
      return stable_tangent(moduli, h);
  }
  throw ContractError("a strain law without a tangent");
}

Tangent9 project_to_semidefinite(const Tangent9& tangent) {
  using Rows9 = Eigen::Matrix<double, 9, 9, Eigen::RowMajor>;
  const Eigen::SelfAdjointEigenSolver<Rows9> eigen(Eigen::Map<const Rows9>(tangent.data()));
  const Rows9& vectors = eigen.eigenvectors();
  Tangent9 out;
  Eigen::Map<Rows9>(out.data()) =
      vectors * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() * vectors.transpose();
  return out;
}

}  // namespace palpate::dynamics

#include "reference/finite_spheres/functions.h"

#include <array>
#include <cmath>
#include <string>

#include "core/base/error.h"
#include "core/dynamics/linear_algebra/matrix3.h"

namespace palpate::reference {

using dynamics::Mat3;

namespace {

/// Least determinant of the spread of the centres, over the cube of a third of its trace, that is no
/// rounding.
constexpr double kLeastSpread = 1e-12;

/// w(s) with s = |x - x_I| / r, and its gradient: dw/dx = -12 (1 - s)^2 (x - x_I) / r^2.
struct Weight {
  double value = 0.0;
  Vec3 gradient;
};

Weight weight_at(const Vec3& from_centre, double radius) {
  const double share = length(from_centre) / radius;
  const double left = 1.0 - share;
  return {quartic_spline(share), (-12.0 * left * left / (radius * radius)) * from_centre};
}

/// A vector of four: (c, v).
struct Linear {
  double c = 0.0;
  Vec3 v;
};

/// A = (m0, m1^T; m1, M2), solved by its Schur complement S = M2 - m1 m1^T / m0.
class Moments {
 public:
  void add(double weight, const Vec3& d) {
    m0_ += weight;
    m1_ = m1_ + weight * d;
    m2_ += weight * dynamics::outer(d, d);
  }

  /// False if S cannot be inverted.
  bool prepare() {
    const Mat3 spread = m2_ - (1.0 / m0_) * dynamics::outer(m1_, m1_);
    const double det = dynamics::determinant(spread);
    const double mean = dynamics::trace(spread) / 3.0;
    if (!(det > kLeastSpread * mean * mean * mean)) return false;
    inverse_ = (1.0 / det) * dynamics::transpose(dynamics::cofactors(spread));
    return true;
  }

  Linear solve(const Linear& f) const {
    const Vec3 v = inverse_ * (f.v - (f.c / m0_) * m1_);
    return {(f.c - dot(m1_, v)) / m0_, v};
  }

 private:
  double m0_ = 0.0;
  Vec3 m1_;
  Mat3 m2_;
  Mat3 inverse_;
};

double times(const Linear& a, const Vec3& d) {
  return a.c + dot(a.v, d);
}

/// Turns weights into functions of moving least squares. From A b = e_0 and dP_I/dx_k = -e_k follows
///   dphi_I/dx_k = dw_I/dx_k P_I . b + w_I P_I . y_k,   A y_k = e_k - sum dw_J/dx_k (P_J . b) P_J.
void apply_least_squares(const Spheres& spheres, std::size_t tet, const Vec3& at, FunctionValues& out) {
  Moments moments;
  for (std::size_t i = 0; i < out.numbers.size(); ++i)
    moments.add(out.values[i], spheres.centres_m[out.numbers[i]] - at);
  if (out.numbers.empty() || !moments.prepare())
    throw InputError("the mesh", 0, "spheres whose centres are not in one plane, in each tet",
                     "a flat part near tet " + std::to_string(tet));
  const Linear b = moments.solve({1.0, {}});
  std::array<Linear, 3> left{Linear{0.0, {1.0, 0.0, 0.0}}, {0.0, {0.0, 1.0, 0.0}}, {0.0, {0.0, 0.0, 1.0}}};
  for (std::size_t i = 0; i < out.numbers.size(); ++i) {
    const Vec3 d = spheres.centres_m[out.numbers[i]] - at;
    const Vec3 q = times(b, d) * out.gradients[i];
    const std::array<double, 3> by_axis{q.x, q.y, q.z};
    for (std::size_t k = 0; k < 3; ++k) {
      left[k].c -= by_axis[k];
      left[k].v = left[k].v - by_axis[k] * d;
    }
  }
  const std::array<Linear, 3> y{moments.solve(left[0]), moments.solve(left[1]), moments.solve(left[2])};
  for (std::size_t i = 0; i < out.numbers.size(); ++i) {
    const Vec3 d = spheres.centres_m[out.numbers[i]] - at;
    const double plane = times(b, d);
    const double w = out.values[i];
    out.gradients[i] = plane * out.gradients[i] + w * Vec3{times(y[0], d), times(y[1], d), times(y[2], d)};
    out.values[i] = w * plane;
  }
}

/// Turns weights into Shepard functions times the linear polynomials of each sphere.
void apply_shepard(const Spheres& spheres, const Vec3& at, FunctionValues& out) {
  double sum = 0.0;
  Vec3 sum_gradient;
  for (std::size_t i = 0; i < out.numbers.size(); ++i) {
    sum += out.values[i];
    sum_gradient = sum_gradient + out.gradients[i];
  }
  const std::size_t count = out.numbers.size();
  out.numbers.resize(4 * count);
  out.values.resize(4 * count);
  out.gradients.resize(4 * count);
  for (std::size_t i = count; i-- > 0;) {  // from behind: four places for each one that is read
    const Index sphere = out.numbers[i];
    const double unity = out.values[i] / sum;
    const Vec3 gradient = (1.0 / sum) * (out.gradients[i] - unity * sum_gradient);
    const double scale = 1.0 / spheres.radii_m[sphere];
    const Vec3 from = scale * (at - spheres.centres_m[sphere]);
    const std::array<double, 4> p{1.0, from.x, from.y, from.z};
    const std::array<Vec3, 4> dp{Vec3{}, {scale, 0.0, 0.0}, {0.0, scale, 0.0}, {0.0, 0.0, scale}};
    for (std::size_t n = 0; n < 4; ++n) {
      out.numbers[4 * i + n] = static_cast<Index>(4 * std::size_t{sphere} + n);
      out.values[4 * i + n] = unity * p[n];
      out.gradients[4 * i + n] = p[n] * gradient + unity * dp[n];
    }
  }
}

}  // namespace

std::size_t functions_per_sphere(SphereFunctions kind) {
  return kind == SphereFunctions::kShepard ? 4 : 1;
}

double quartic_spline(double share) {
  const double left = 1.0 - share;
  return share < 1.0 ? left * left * left * (1.0 + 3.0 * share) : 0.0;
}

void evaluate_functions(const Spheres& spheres, SphereFunctions kind, std::size_t tet, const Vec3& at,
                        FunctionValues& out) {
  out.numbers.clear();
  out.values.clear();
  out.gradients.clear();
  for (const Index sphere : spheres.of(tet)) {
    const Vec3 from = at - spheres.centres_m[sphere];
    const double radius = spheres.radii_m[sphere];
    if (!(length_sq(from) < radius * radius)) continue;
    const Weight weight = weight_at(from, radius);
    out.numbers.push_back(sphere);
    out.values.push_back(weight.value);
    out.gradients.push_back(weight.gradient);
  }
  if (kind == SphereFunctions::kShepard) {
    apply_shepard(spheres, at, out);
  } else {
    apply_least_squares(spheres, tet, at, out);
  }
}

}  // namespace palpate::reference

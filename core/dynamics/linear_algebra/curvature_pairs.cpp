#include "core/dynamics/linear_algebra/curvature_pairs.h"

#include <algorithm>

#include "core/dynamics/linear_algebra/vertex_field.h"

namespace palpate::dynamics {

CurvaturePairs::CurvaturePairs(std::size_t vertices) {
  for (Pair& pair : pairs_) {
    pair.s.resize(vertices);
    pair.y.resize(vertices);
  }
}

void CurvaturePairs::keep(std::span<const Vec3> s, std::span<const Vec3> y) {
  constexpr double kRounding = 1e-12;
  const double curvature = dot_of(s, y);
  if (!(curvature > kRounding * norm_of(s) * norm_of(y))) return;
  Pair& pair = pairs_.at(next_);
  std::copy(s.begin(), s.end(), pair.s.begin());
  std::copy(y.begin(), y.end(), pair.y.begin());
  pair.inverse_curvature = 1.0 / curvature;
  next_ = (next_ + 1) % kMost;
  count_ = std::min(count_ + 1, kMost);
}

void CurvaturePairs::apply(std::span<Vec3> field,
                           const std::function<void(std::span<Vec3>)>& approximate) const {
  std::array<double, kMost> along{};
  for (std::size_t age = 0; age < count_; ++age) {
    const Pair& pair = aged(age);
    along.at(age) = pair.inverse_curvature * dot_of(pair.s, field);
    add_scaled(field, -along.at(age), pair.y);
  }
  approximate(field);
  for (std::size_t age = count_; age-- > 0;) {
    const Pair& pair = aged(age);
    add_scaled(field, along.at(age) - pair.inverse_curvature * dot_of(pair.y, field), pair.s);
  }
}

}  // namespace palpate::dynamics

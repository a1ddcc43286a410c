// Sums over fields of vectors, one a vertex.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/types.h"

namespace palpate::dynamics {

/// Sum of a_v . b_v. Requires: fields of one size, here and below.
inline double dot_of(std::span<const Vec3> a, std::span<const Vec3> b) {
  double sum = 0.0;
  for (std::size_t v = 0; v < a.size(); ++v) sum += dot(a[v], b[v]);
  return sum;
}

/// sqrt(dot_of(a, a)).
inline double norm_of(std::span<const Vec3> a) {
  return std::sqrt(dot_of(a, a));
}

/// a += s b.
inline void add_scaled(std::span<Vec3> a, double s, std::span<const Vec3> b) {
  for (std::size_t v = 0; v < a.size(); ++v) a[v] = a[v] + s * b[v];
}

/// Sets the held components (bit i of held[v]: axis i) to zero.
inline void clear_held(std::span<const std::uint8_t> held, std::span<Vec3> a) {
  for (std::size_t v = 0; v < a.size(); ++v) {
    if ((held[v] & 1U) != 0) a[v].x = 0.0;
    if ((held[v] & 2U) != 0) a[v].y = 0.0;
    if ((held[v] & 4U) != 0) a[v].z = 0.0;
  }
}

}  // namespace palpate::dynamics

// Index and vector types that every floor shares.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

namespace palpate {

/// Index of a vertex or an element. 32 bits hold meshes of up to 2^32 - 2 entries.
using Index = std::uint32_t;

/// "No such vertex or element."
inline constexpr Index kNoIndex = 0xffffffffU;

/// A point or a vector, in the length unit of its mesh.
struct Vec3 {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;

  friend constexpr Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend constexpr Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend constexpr Vec3 operator*(double s, const Vec3& a) { return {s * a.x, s * a.y, s * a.z}; }
  friend constexpr bool operator==(const Vec3& a, const Vec3& b) = default;
};

/// a . b.
constexpr double dot(const Vec3& a, const Vec3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// a x b.
constexpr Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// a . a.
constexpr double length_sq(const Vec3& a) {
  return dot(a, a);
}

/// |a|, in the unit of a.
inline double length(const Vec3& a) {
  return std::sqrt(length_sq(a));
}

/// Whether no coordinate is NaN or infinite.
inline bool is_finite(const Vec3& a) {
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}

/// Vertex indices of a tetrahedron (a, b, c, d). Positively oriented when (b - a) x (c - a) . (d - a) > 0.
using Tet = std::array<Index, 4>;

/// Vertex indices of a triangle, counter-clockwise seen from outside.
using Triangle = std::array<Index, 3>;

/// Vertex indices of an edge, smaller first.
using Edge = std::array<Index, 2>;

/// Local vertex numbers of the four faces of a positively oriented tet, each counter-clockwise seen from
/// outside; face i is opposite to vertex i.
inline constexpr std::array<std::array<int, 3>, 4> kTetFaces{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

/// Local vertex numbers of the six edges of a tet.
inline constexpr std::array<std::array<int, 2>, 6> kTetEdges{
    {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

}  // namespace palpate

// Surfaces moved, turned and put together, and as STL files.
#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "core/mesh/tet_mesh.h"

namespace palpate::test {

/// Scaled, then moved.
inline SurfaceMesh moved(SurfaceMesh surface, double scale, const Vec3& by) {
  for (Vec3& p : surface.points) p = scale * p + by;
  return surface;
}

/// Inside out.
inline SurfaceMesh turned(SurfaceMesh surface) {
  for (Triangle& t : surface.triangles) std::swap(t[1], t[2]);
  return surface;
}

/// Both in one, without a vertex in common.
inline SurfaceMesh united(SurfaceMesh a, const SurfaceMesh& b) {
  const auto offset = static_cast<Index>(a.points.size());
  a.points.insert(a.points.end(), b.points.begin(), b.points.end());
  for (const Triangle& t : b.triangles) a.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  return a;
}

/// With six decimals.
inline std::string ascii_stl(const SurfaceMesh& s) {
  std::string text = "solid a\n";
  for (const Triangle& t : s.triangles) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const Index v : t) {
      const Vec3& p = s.points[v];
      text += "vertex " + std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z) + "\n";
    }
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid a\n";
}

/// In single precision.
inline std::string binary_stl(const SurfaceMesh& s) {
  std::string bytes(80, ' ');
  const auto append = [&](const auto& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  append(static_cast<std::uint32_t>(s.triangles.size()));
  for (const Triangle& t : s.triangles) {
    bytes.append(12, '\0');
    for (const Index v : t) {
      const Vec3& p = s.points[v];
      for (const double c : {p.x, p.y, p.z}) append(static_cast<float>(c));
    }
    bytes.append(2, '\0');
  }
  return bytes;
}

}  // namespace palpate::test

// Built with CGAL, GPL: this program is distributed under GPL-3.0-or-later.
#include <algorithm>
#include <cstdio>
#include <vector>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "reference/cgal/surface_tools.h"

namespace palpate::reference {
namespace {

std::string shown(const Vec3& p) {
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), "(%.6g, %.6g, %.6g)", p.x, p.y, p.z);
  return text.data();
}

/// A triangle's side, from corner to corner.
struct Side {
  Edge edge;     ///< smaller vertex first
  bool forward;  ///< does the triangle run from the smaller to the larger?
};

std::vector<Side> sorted_sides(const SurfaceMesh& surface) {
  std::vector<Side> sides;
  sides.reserve(3 * surface.triangles.size());
  for (const Triangle& t : surface.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Index a = t[k];
      const Index b = t[(k + 1) % 3];
      sides.push_back({{std::min(a, b), std::max(a, b)}, a < b});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return a.edge != b.edge ? a.edge < b.edge : a.forward < b.forward;
  });
  return sides;
}

/// How many edges are at fault in one way, and the first.
struct EdgeFault {
  std::size_t count = 0;
  Edge first{};

  void add(const Edge& edge) {
    if (count++ == 0) first = edge;
  }
};

void check_edges(const SurfaceMesh& surface, const std::string& where) {
  EdgeFault border;
  EdgeFault crowded;
  EdgeFault turned;
  const std::vector<Side> sides = sorted_sides(surface);
  for (std::size_t first = 0; first < sides.size();) {
    std::size_t last = first + 1;
    while (last < sides.size() && sides[last].edge == sides[first].edge) ++last;
    if (last - first == 1) border.add(sides[first].edge);
    if (last - first > 2) crowded.add(sides[first].edge);
    if (last - first == 2 && sides[first].forward == sides[first + 1].forward) turned.add(sides[first].edge);
    first = last;
  }
  const auto place = [&](const EdgeFault& fault) {
    return shown(surface.points[fault.first[0]]) + " - " + shown(surface.points[fault.first[1]]);
  };
  if (crowded.count > 0) {
    throw InputError(where, 0, "a manifold surface",
                     std::to_string(crowded.count) +
                         " edges with more than two triangles (non-manifold), one at " + place(crowded));
  }
  if (border.count > 0) {
    throw InputError(where, 0, "a closed surface",
                     std::to_string(border.count) + " border edges (open), one at " + place(border));
  }
  if (turned.count > 0) {
    throw InputError(where, 0, "triangles that all turn the same way",
                     std::to_string(turned.count) +
                         " edges where two neighbours turn against each other, one at " + place(turned));
  }
}

/// Walks around each vertex from one of its triangles: all must be reached. Requires checked edges.
void check_vertices(const SurfaceMesh& surface, const std::string& where) {
  // next[(a, b)] = c for each triangle (a, b, c), looked up in the row of a.
  std::vector<std::vector<std::array<Index, 2>>> rows(surface.points.size());
  for (const Triangle& t : surface.triangles) {
    for (std::size_t k = 0; k < 3; ++k) rows[t[k]].push_back({t[(k + 1) % 3], t[(k + 2) % 3]});
  }
  std::size_t count = 0;
  Index first = kNoIndex;
  for (Index v = 0; v < rows.size(); ++v) {
    std::size_t reached = 0;
    Index at = rows[v].front()[0];
    do {
      const auto entry =
          std::find_if(rows[v].begin(), rows[v].end(), [&](const auto& e) { return e[0] == at; });
      require(entry != rows[v].end(), "check_vertices: the edges were not checked");
      at = (*entry)[1];
      ++reached;
    } while (at != rows[v].front()[0]);
    if (reached == rows[v].size()) continue;
    if (count++ == 0) first = v;
  }
  if (count > 0) {
    throw InputError(where, 0, "a manifold surface",
                     std::to_string(count) + " vertices where separate sheets touch (non-manifold), one at " +
                         shown(surface.points[first]));
  }
}

}  // namespace

void check_closed_surface(const SurfaceMesh& surface, const std::string& where) {
  for (const Triangle& t : surface.triangles) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
      throw InputError(where, 0, "triangles with three corners",
                       "one whose corners coincide at " + shown(surface.points[t[0]]));
    }
  }
  check_edges(surface, where);
  check_vertices(surface, where);
  const Intersections crossings = find_self_intersections(surface);
  if (crossings.pairs > 0) {
    throw InputError(where, 0, "a surface that does not intersect itself",
                     std::to_string(crossings.pairs) + " pairs of triangles that intersect, one at " +
                         shown(crossings.place));
  }
  const double volume = enclosed_volume(surface);
  if (!(volume > 0.0)) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.6g", volume);
    throw InputError(where, 0, "triangles that are counter-clockwise seen from outside",
                     std::string("a volume of ") + text.data() + " (the surface is inside out)");
  }
  if (!is_nested_well(surface)) {
    throw InputError(where, 0, "separate pieces, or cavities that are turned inward",
                     "pieces nested in each other the wrong way round");
  }
}

}  // namespace palpate::reference

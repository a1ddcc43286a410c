#include "core/mesh/topology.h"

#include <algorithm>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/parallel.h"

namespace palpate {
namespace {

Triangle sorted(Triangle t) {
  if (t[0] > t[1]) std::swap(t[0], t[1]);
  if (t[1] > t[2]) std::swap(t[1], t[2]);
  if (t[0] > t[1]) std::swap(t[0], t[1]);
  return t;
}

/// Is (a, b, c) an even permutation of its sorted form?
bool is_even(const Triangle& t) {
  return (t[0] < t[1] && t[1] < t[2]) || (t[1] < t[2] && t[2] < t[0]) || (t[2] < t[0] && t[0] < t[1]);
}

std::string name_of(const Triangle& t) {
  return "face (" + std::to_string(t[0] + 1) + ", " + std::to_string(t[1] + 1) + ", " +
         std::to_string(t[2] + 1) + ")";
}

/// A face seen from one tet, in the row of its smallest vertex: 12 bytes.
struct HalfFace {
  Index middle;
  Index largest;
  Index code;  ///< 4 * tet + local face

  friend bool operator<(const HalfFace& a, const HalfFace& b) {
    if (a.middle != b.middle) return a.middle < b.middle;
    if (a.largest != b.largest) return a.largest < b.largest;
    return a.code < b.code;
  }
};

Triangle oriented_face(const TetMesh& mesh, Index code) {
  const Tet& tet = mesh.tets[code / 4];
  const auto& local = kTetFaces[code % 4];
  return {tet[local[0]], tet[local[1]], tet[local[2]]};
}

/// The half faces in compressed rows by smallest vertex, each row sorted, so that partners are neighbours.
struct HalfFaceRows {
  std::vector<std::uint64_t> offsets;
  std::vector<HalfFace> faces;
};

/// Each thread fills and sorts the rows of a range of vertices. It reads all tets for that, which costs less
/// than handing the faces out.
HalfFaceRows build_half_faces(const TetMesh& mesh, int threads) {
  require(mesh.tets.size() < (1U << 30U), "build_half_faces: too many tets for 32-bit codes");
  HalfFaceRows rows;
  rows.offsets.assign(mesh.points.size() + 1, 0);
  const Index codes = static_cast<Index>(4 * mesh.tets.size());
  for (Index code = 0; code < codes; ++code) {
    const Triangle face = oriented_face(mesh, code);
    ++rows.offsets[std::min({face[0], face[1], face[2]}) + 1];
  }
  for (std::size_t v = 1; v < rows.offsets.size(); ++v) rows.offsets[v] += rows.offsets[v - 1];
  rows.faces.resize(codes);
  std::vector<std::uint64_t> next(rows.offsets.begin(), rows.offsets.end() - 1);
  for_ranges(mesh.points.size(), threads, [&](std::size_t first, std::size_t last, std::size_t) {
    for (Index code = 0; code < codes; ++code) {
      const Triangle face = oriented_face(mesh, code);
      const Index least = std::min({face[0], face[1], face[2]});
      if (least < first || least >= last) continue;
      const Triangle in_order = sorted(face);
      rows.faces[next[least]++] = {in_order[1], in_order[2], code};
    }
    for (std::size_t v = first; v < last; ++v) {
      std::sort(rows.faces.begin() + static_cast<std::ptrdiff_t>(rows.offsets[v]),
                rows.faces.begin() + static_cast<std::ptrdiff_t>(rows.offsets[v + 1]));
    }
  });
  return rows;
}

/// Calls visit(first, count) for each group of half faces with the same vertices, in sorted order.
template <typename Visit>
void for_each_face(const HalfFaceRows& rows, Visit&& visit, std::size_t first_vertex = 0,
                   std::size_t end_vertex = kNoIndex) {
  end_vertex = std::min(end_vertex, rows.offsets.size() - 1);
  for (std::size_t v = first_vertex; v < end_vertex; ++v) {
    std::uint64_t first = rows.offsets[v];
    while (first < rows.offsets[v + 1]) {
      std::uint64_t last = first + 1;
      while (last < rows.offsets[v + 1] && rows.faces[last].middle == rows.faces[first].middle &&
             rows.faces[last].largest == rows.faces[first].largest) {
        ++last;
      }
      visit(static_cast<Index>(v), first, last - first);
      first = last;
    }
  }
}

void check_face_count(const Triangle& face, std::uint64_t count) {
  if (count > 2) {
    throw InputError(name_of(face), 0, "one or two tetrahedra", std::to_string(count) + " (non-manifold)");
  }
}

void check_opposite_sides(const TetMesh& mesh, const Triangle& face, Index code_a, Index code_b) {
  if (is_even(oriented_face(mesh, code_a)) != is_even(oriented_face(mesh, code_b))) return;
  throw InputError(name_of(face), 0, "its two tetrahedra on opposite sides",
                   "tetrahedra " + std::to_string(code_a / 4 + 1) + " and " + std::to_string(code_b / 4 + 1) +
                       " on the same side (inverted)");
}

std::vector<Triangle> collect_unpaired(const TetMesh& mesh, const HalfFaceRows& rows) {
  std::vector<Index> codes;
  for_each_face(rows, [&](Index, std::uint64_t first, std::uint64_t count) {
    if (count == 1) codes.push_back(rows.faces[first].code);
  });
  std::sort(codes.begin(), codes.end());
  std::vector<Triangle> unpaired;
  unpaired.reserve(codes.size());
  for (const Index code : codes) unpaired.push_back(oriented_face(mesh, code));
  return unpaired;
}

}  // namespace

VertexStars build_vertex_stars(const TetMesh& mesh, int threads) {
  require(mesh.tets.size() < (1U << 30U), "build_vertex_stars: too many tets for 32-bit rows");
  VertexStars stars;
  stars.offsets.assign(mesh.points.size() + 1, 0);
  for (const Tet& tet : mesh.tets) {
    for (const Index v : tet) ++stars.offsets[v + 1];
  }
  for (std::size_t v = 1; v < stars.offsets.size(); ++v) stars.offsets[v] += stars.offsets[v - 1];
  stars.tets.resize(4 * mesh.tets.size());
  // The row starts double as cursors; shifting them back afterwards saves a second array.
  for_ranges(mesh.points.size(), threads, [&](std::size_t first, std::size_t last, std::size_t) {
    for (Index t = 0; t < mesh.tets.size(); ++t) {
      for (const Index v : mesh.tets[t]) {
        if (v >= first && v < last) stars.tets[stars.offsets[v]++] = t;
      }
    }
  });
  for (std::size_t v = stars.offsets.size() - 1; v > 0; --v) stars.offsets[v] = stars.offsets[v - 1];
  stars.offsets[0] = 0;
  return stars;
}

std::vector<Edge> build_edges(const TetMesh& mesh) {
  std::vector<std::uint64_t> offsets(mesh.points.size() + 1, 0);
  for (const Tet& tet : mesh.tets) {
    for (const auto& [i, j] : kTetEdges) ++offsets[std::min(tet[i], tet[j]) + 1];
  }
  for (std::size_t v = 1; v < offsets.size(); ++v) offsets[v] += offsets[v - 1];
  std::vector<Index> others(6 * mesh.tets.size());
  std::vector<std::uint64_t> next(offsets.begin(), offsets.end() - 1);
  for (const Tet& tet : mesh.tets) {
    for (const auto& [i, j] : kTetEdges) others[next[std::min(tet[i], tet[j])]++] = std::max(tet[i], tet[j]);
  }
  // From here on, next[v] is the end of the different neighbours in row v.
  std::size_t count = 0;
  const auto at = [&](std::uint64_t i) { return others.begin() + static_cast<std::ptrdiff_t>(i); };
  for (std::size_t v = 0; v < next.size(); ++v) {
    std::sort(at(offsets[v]), at(offsets[v + 1]));
    next[v] = static_cast<std::uint64_t>(std::unique(at(offsets[v]), at(offsets[v + 1])) - others.begin());
    count += next[v] - offsets[v];
  }
  std::vector<Edge> edges;
  edges.reserve(count);
  for (Index v = 0; v < next.size(); ++v) {
    for (std::uint64_t i = offsets[v]; i < next[v]; ++i) edges.push_back({v, others[i]});
  }
  return edges;
}

std::vector<Face> build_faces(const TetMesh& mesh) {
  const HalfFaceRows rows = build_half_faces(mesh, 1);
  std::size_t face_count = 0;
  for_each_face(rows, [&](Index, std::uint64_t, std::uint64_t) { ++face_count; });
  std::vector<Face> faces;
  faces.reserve(face_count);
  for_each_face(rows, [&](Index v, std::uint64_t first, std::uint64_t count) {
    const HalfFace& half = rows.faces[first];
    const Triangle vertices{v, half.middle, half.largest};
    check_face_count(vertices, count);
    faces.push_back({vertices, {half.code / 4, count == 2 ? rows.faces[first + 1].code / 4 : kNoIndex}});
  });
  return faces;
}

std::vector<Triangle> build_boundary(const TetMesh& mesh, int threads) {
  const HalfFaceRows rows = build_half_faces(mesh, threads);
  for_ranges(mesh.points.size(), threads, [&](std::size_t begin, std::size_t end, std::size_t) {
    const auto check = [&](Index v, std::uint64_t first, std::uint64_t count) {
      const HalfFace& half = rows.faces[first];
      const Triangle vertices{v, half.middle, half.largest};
      check_face_count(vertices, count);
      if (count == 2) check_opposite_sides(mesh, vertices, half.code, rows.faces[first + 1].code);
    };
    for_each_face(rows, check, begin, end);
  });
  return collect_unpaired(mesh, rows);
}

std::vector<Triangle> build_unpaired_faces(const TetMesh& mesh) {
  return collect_unpaired(mesh, build_half_faces(mesh, 1));
}

std::vector<std::uint8_t> build_boundary_vertex_flags(const TetMesh& mesh, int threads) {
  std::vector<std::uint8_t> flags(mesh.points.size(), 0);
  for (const Triangle& face : build_boundary(mesh, threads)) {
    for (const Index v : face) flags[v] = 1;
  }
  return flags;
}

std::size_t remove_isolated_vertices(TetMesh& mesh) {
  std::vector<Index> new_index(mesh.points.size(), kNoIndex);
  for (const Tet& tet : mesh.tets) {
    for (const Index v : tet) new_index[v] = 0;
  }
  Index kept = 0;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    if (new_index[v] == kNoIndex) continue;
    new_index[v] = kept;
    mesh.points[kept++] = mesh.points[v];
  }
  const std::size_t removed = mesh.points.size() - kept;
  mesh.points.resize(kept);
  if (removed > 0) {
    for (Tet& tet : mesh.tets) {
      for (Index& v : tet) v = new_index[v];
    }
  }
  return removed;
}

}  // namespace palpate

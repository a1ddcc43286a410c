#include "core/simplify/tet_operations/working_mesh.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/space_order.h"
#include "core/simplify/fusion/fusion.h"

namespace palpate::simplify {
namespace {

/// Spare entries behind each row of a star when the mesh is built.
constexpr Index kSpareInRow = 8;

/// A part of the rows that is full gets room for this share more.
constexpr std::size_t kShareOfRoom = 4;

/// Lays the rows of v's part out anew, in vertex order, with spare entries and room for `more` behind them.
void compact_part(WorkingMesh& mesh, Index v, std::size_t more) {
  std::vector<Index>& rows = mesh.rows_of(v);
  const std::size_t first = v - v % WorkingMesh::kVerticesOfPart;
  const std::size_t last = std::min(mesh.points.size(), first + WorkingMesh::kVerticesOfPart);
  std::size_t size = 0;
  for (std::size_t w = first; w < last; ++w)
    size += mesh.star_size[w] == 0 ? 0 : mesh.star_size[w] + kSpareInRow;
  std::vector<Index> fresh;
  fresh.reserve(size + size / kShareOfRoom + more);
  for (std::size_t w = first; w < last; ++w) {
    const std::size_t begin = fresh.size();
    const auto row = rows.begin() + mesh.star_begin[w];
    fresh.insert(fresh.end(), row, row + mesh.star_size[w]);
    mesh.star_begin[w] = static_cast<Index>(begin);
    mesh.star_capacity[w] = mesh.star_size[w] == 0 ? 0 : mesh.star_size[w] + kSpareInRow;
    fresh.resize(begin + mesh.star_capacity[w]);
  }
  rows = std::move(fresh);
}

/// Gives vertex v room for `size` tets.
void reserve_row(WorkingMesh& mesh, Index v, std::size_t size) {
  if (mesh.star_capacity[v] >= size) return;
  const std::size_t capacity = size + size / 2 + kSpareInRow;
  std::vector<Index>& rows = mesh.rows_of(v);
  if (rows.size() + capacity > rows.capacity()) {
    compact_part(mesh, v, capacity);
    if (mesh.star_capacity[v] >= size) return;
  }
  const std::size_t begin = rows.size();
  rows.resize(begin + capacity);
  std::copy_n(rows.begin() + mesh.star_begin[v], mesh.star_size[v],
              rows.begin() + static_cast<std::ptrdiff_t>(begin));
  mesh.star_begin[v] = static_cast<Index>(begin);
  mesh.star_capacity[v] = static_cast<Index>(capacity);
}

/// Fills the stars, with spare entries; each has its tets in the order of their slots.
void build_stars(WorkingMesh& mesh) {
  const std::size_t vertices = mesh.points.size();
  mesh.star_begin.assign(vertices, 0);
  mesh.star_size.assign(vertices, 0);
  mesh.star_capacity.assign(vertices, 0);
  for (const Tet& tet : mesh.tets) {
    for (const Index v : tet) ++mesh.star_capacity[v];
  }
  for (std::size_t first = 0; first < vertices; first += WorkingMesh::kVerticesOfPart) {
    const std::size_t last = std::min(vertices, first + WorkingMesh::kVerticesOfPart);
    Index end = 0;
    for (std::size_t v = first; v < last; ++v) {
      if (mesh.star_capacity[v] > 0) mesh.star_capacity[v] += kSpareInRow;
      mesh.star_begin[v] = end;
      end += mesh.star_capacity[v];
    }
    mesh.star_rows.emplace_back(end);
  }
  for (Index t = 0; t < mesh.tets.size(); ++t) {
    for (const Index v : mesh.tets[t]) mesh.rows_of(v)[mesh.star_begin[v] + mesh.star_size[v]++] = t;
  }
}

void erase_from_star(WorkingMesh& mesh, Index v, Index tet) {
  const std::span<Index> row = mesh.star(v);
  const auto found = std::find(row.begin(), row.end(), tet);
  require(found != row.end(), "erase_from_star: the tet is not in the star");
  *found = row.back();
  --mesh.star_size[v];
}

void push_to_star(WorkingMesh& mesh, Index v, Index tet) {
  reserve_row(mesh, v, mesh.star_size[v] + 1U);
  mesh.rows_of(v)[mesh.star_begin[v] + mesh.star_size[v]++] = tet;
}

void kill_slot(WorkingMesh& mesh, Index t) {
  require(!mesh.is_kept(t), "a kept tet would die");
  mesh.tets[t][0] = kNoIndex;
  mesh.free_tets.push_back(t);
  --mesh.alive;
}

bool has_vertex(const Tet& tet, Index v) {
  return corners_that_are(tet, v) != 0U;
}

/// The faces at their smallest vertex, as far as they have been met.
struct OpenFaces {
  std::vector<std::uint64_t> keys;  ///< the middle vertex and, in the low half, the largest
  std::vector<std::uint8_t> sides;  ///< bit 0: a tet has it as smallest, middle, largest seen from outside;
                                    ///< bit 1: a tet has it the other way round
};

[[noreturn]] void refuse_face(const WorkingMesh& mesh, Index v, std::uint64_t key) {
  const auto number = [&](std::uint64_t w) {
    return std::to_string(mesh.vertex_origin[static_cast<std::size_t>(w)] + 1);
  };
  throw InputError("face " + number(v) + " " + number(key >> 32U) + " " + number(key & 0xffffffffU), 0,
                   "one or two tetrahedra, on opposite sides", "more, or two on one side");
}

void enter_face(const WorkingMesh& mesh, Index v, Index second, Index third, OpenFaces& faces) {
  const bool upward = second < third;
  const std::uint64_t key =
      upward ? std::uint64_t{second} << 32U | third : std::uint64_t{third} << 32U | second;
  const auto side = static_cast<std::uint8_t>(upward ? 1 : 2);
  const std::size_t size = faces.keys.size();
  std::size_t i = 0;
  while (i < size && faces.keys[i] != key) ++i;
  if (i == size) {
    faces.keys.push_back(key);
    faces.sides.push_back(side);
  } else {
    if ((faces.sides[i] & side) != 0) refuse_face(mesh, v, key);
    faces.sides[i] = 3;
  }
}

/// Enters the faces of the star of v of which v is the smallest vertex.
void enter_faces_of(const WorkingMesh& mesh, Index v, OpenFaces& faces) {
  faces.keys.clear();
  faces.sides.clear();
  for (const Index t : mesh.star(v)) {
    const Tet& tet = mesh.tets[t];
    std::size_t smaller = 0;
    for (const Index w : tet) smaller += w < v ? 1U : 0U;
    if (smaller > 1) continue;
    for (std::size_t corner = 0; corner < 4; ++corner) {
      // The face opposite to this corner: v is its smallest vertex if the corner is the one smaller than v,
      // or if there is none and the corner is not v itself.
      if (tet[corner] == v || (smaller == 1 && tet[corner] > v)) continue;
      const Triangle f = face_opposite(tet, corner);
      const std::size_t at = f[0] == v ? 0U : (f[1] == v ? 1U : 2U);
      enter_face(mesh, v, f[(at + 1) % 3], f[(at + 2) % 3], faces);
    }
  }
}

/// Flags the vertices of faces that have one tet only. Linear time, as stars are short.
void mark_boundary(WorkingMesh& mesh) {
  OpenFaces faces;
  for (Index v = 0; v < mesh.points.size(); ++v) {
    enter_faces_of(mesh, v, faces);
    for (std::size_t i = 0; i < faces.keys.size(); ++i) {
      if (faces.sides[i] == 3) continue;
      mesh.vertex_flags[v] |= kOnBoundary;
      mesh.vertex_flags[static_cast<std::size_t>(faces.keys[i] >> 32U)] |= kOnBoundary;
      mesh.vertex_flags[static_cast<std::size_t>(faces.keys[i] & 0xffffffffU)] |= kOnBoundary;
    }
  }
}

}  // namespace

WorkingMesh build_working_mesh(TetMesh&& mesh, const SizingField& field) {
  WorkingMesh result;
  std::vector<std::uint8_t> kept;
  if (!field.is_empty()) kept = build_kept_tets(field, mesh);
  MeshOrigin origin = sort_in_space(mesh);
  if (kept.empty()) std::vector<Index>().swap(origin.tets);
  result.points = std::move(mesh.points);
  result.tets = std::move(mesh.tets);
  mesh = {};
  result.vertex_origin = std::move(origin.vertices);
  result.alive = result.tets.size();
  build_stars(result);
  result.score.assign(result.tets.size(), WorkingMesh::kNoScore);
  result.vertex_flags.assign(result.points.size(), kFree);
  if (!kept.empty()) {
    result.kept_tets.resize(kept.size());
    for (std::size_t t = 0; t < kept.size(); ++t) {
      result.kept_tets[t] = kept[origin.tets[t]];
      if (result.kept_tets[t] == 0) continue;
      for (const Index v : result.tets[t]) result.vertex_flags[v] |= kFrozen;
    }
  }
  mark_boundary(result);
  return result;
}

TetMesh extract_mesh(WorkingMesh&& mesh) {
  std::vector<std::vector<Index>>().swap(mesh.star_rows);
  std::vector<float>().swap(mesh.score);
  std::vector<Index> storage_of(mesh.points.size(), kNoIndex);
  std::vector<Index> added;
  for (Index v = 0; v < mesh.points.size(); ++v) {
    if (!mesh.is_vertex_alive(v)) continue;
    if (mesh.vertex_origin[v] == kNoIndex) {
      added.push_back(v);
    } else {
      storage_of[mesh.vertex_origin[v]] = v;
    }
  }
  std::erase(storage_of, kNoIndex);
  storage_of.insert(storage_of.end(), added.begin(), added.end());
  TetMesh result;
  result.points.reserve(storage_of.size());
  std::vector<Index> new_number(mesh.points.size(), kNoIndex);
  for (const Index v : storage_of) {
    new_number[v] = static_cast<Index>(result.points.size());
    result.points.push_back(mesh.points[v]);
  }
  const auto first_vertex = [](const Tet& t) { return std::min({t[0], t[1], t[2], t[3]}); };
  std::vector<Index> begin(result.points.size() + 1, 0);
  for (Tet& tet : mesh.tets) {
    if (tet[0] == kNoIndex) continue;
    for (Index& v : tet) v = new_number[v];
    ++begin[first_vertex(tet) + 1];
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  result.tets.resize(mesh.alive);
  for (const Tet& tet : mesh.tets) {
    if (tet[0] != kNoIndex) result.tets[begin[first_vertex(tet)]++] = tet;
  }
  mesh = {};
  return result;
}

void apply_move(WorkingMesh& mesh, Index v, const Vec3& to) {
  mesh.points[v] = to;
  for (const Index t : mesh.star(v)) mesh.score[t] = WorkingMesh::kNoScore;
}

std::size_t apply_collapse(WorkingMesh& mesh, Index gone, Index survivor, const Vec3& to) {
  reserve_row(mesh, survivor, mesh.star_size[survivor] + mesh.star_size[gone]);
  const std::size_t before = mesh.alive;
  for (const Index t : mesh.star(gone)) {
    Tet& tet = mesh.tets[t];
    if (has_vertex(tet, survivor)) {
      for (const Index v : tet) {
        if (v != gone) erase_from_star(mesh, v, t);
      }
      kill_slot(mesh, t);
    } else {
      require(!mesh.is_kept(t), "apply_collapse: a kept tet would change");
      *std::find(tet.begin(), tet.end(), gone) = survivor;
      mesh.rows_of(survivor)[mesh.star_begin[survivor] + mesh.star_size[survivor]++] = t;
    }
  }
  mesh.star_size[gone] = 0;
  mesh.free_vertices.push_back(gone);
  apply_move(mesh, survivor, to);
  return before - mesh.alive;
}

void apply_flip(WorkingMesh& mesh, std::span<const Index> old, std::span<const Tet> fresh,
                std::vector<Index>& added) {
  for (const Index t : old) {
    for (const Index v : mesh.tets[t]) erase_from_star(mesh, v, t);
    kill_slot(mesh, t);
  }
  added.clear();
  for (const Tet& tet : fresh) {
    Index slot = static_cast<Index>(mesh.tets.size());
    if (mesh.free_tets.empty()) {
      mesh.tets.push_back(tet);
      mesh.score.push_back(WorkingMesh::kNoScore);
    } else {
      slot = mesh.free_tets.back();
      mesh.free_tets.pop_back();
      mesh.tets[slot] = tet;
      mesh.score[slot] = WorkingMesh::kNoScore;
    }
    ++mesh.alive;
    for (const Index v : tet) push_to_star(mesh, v, slot);
    added.push_back(slot);
  }
}

Index add_vertex(WorkingMesh& mesh, const Vec3& at) {
  if (!mesh.free_vertices.empty()) {
    const Index v = mesh.free_vertices.back();
    mesh.free_vertices.pop_back();
    mesh.points[v] = at;
    mesh.vertex_flags[v] = kFree;
    mesh.vertex_origin[v] = kNoIndex;
    return v;
  }
  mesh.points.push_back(at);
  mesh.vertex_flags.push_back(kFree);
  mesh.vertex_origin.push_back(kNoIndex);
  mesh.star_begin.push_back(0);
  mesh.star_size.push_back(0);
  mesh.star_capacity.push_back(0);
  if (mesh.points.size() > mesh.star_rows.size() * WorkingMesh::kVerticesOfPart)
    mesh.star_rows.emplace_back();
  return static_cast<Index>(mesh.points.size() - 1);
}

void remove_vertex(WorkingMesh& mesh, Index v) {
  require(mesh.star_size[v] == 0, "remove_vertex: the vertex has tets");
  mesh.free_vertices.push_back(v);
}

void collect_edge_star(const WorkingMesh& mesh, Index a, Index b, std::vector<Index>& result) {
  result.clear();
  if (mesh.star_size[b] < mesh.star_size[a]) std::swap(a, b);
  for (const Index t : mesh.star(a)) {
    if (has_vertex(mesh.tets[t], b)) result.push_back(t);
  }
}

Index find_tet(const WorkingMesh& mesh, const Tet& tet) {
  for (const Index t : mesh.star(tet[0])) {
    const Tet& other = mesh.tets[t];
    if (std::is_permutation(other.begin(), other.end(), tet.begin())) return t;
  }
  throw ContractError("find_tet: no tet has these vertices");
}

Index neighbour_across(const WorkingMesh& mesh, Index tet, Index a, Index b, Index c) {
  for (const Index t : mesh.star(a)) {
    if (t != tet && has_vertex(mesh.tets[t], b) && has_vertex(mesh.tets[t], c)) return t;
  }
  return kNoIndex;
}

void collect_boundary_faces(const WorkingMesh& mesh, Index v, std::vector<Triangle>& result) {
  result.clear();
  for (const Index t : mesh.star(v)) {
    const Tet& tet = mesh.tets[t];
    for (const auto& local : kTetFaces) {
      Triangle face{tet[static_cast<std::size_t>(local[0])], tet[static_cast<std::size_t>(local[1])],
                    tet[static_cast<std::size_t>(local[2])]};
      const auto at = std::find(face.begin(), face.end(), v);
      if (at == face.end() || !mesh.is_on_boundary(face[0]) || !mesh.is_on_boundary(face[1]) ||
          !mesh.is_on_boundary(face[2])) {
        continue;
      }
      std::rotate(face.begin(), at, face.end());
      if (neighbour_across(mesh, t, face[0], face[1], face[2]) == kNoIndex) result.push_back(face);
    }
  }
}

bool meets_link_condition(const WorkingMesh& mesh, Index gone, Index survivor, VertexMarks& marks) {
  constexpr std::uint32_t kInLinkOfKept = 1;
  constexpr std::uint32_t kInRing = 2;
  marks.clear(mesh.points.size());
  for (const Index t : mesh.star(survivor)) {
    for (const Index v : mesh.tets[t]) marks.set(v, kInLinkOfKept);
  }
  for (const Index t : mesh.star(gone)) {
    if (!has_vertex(mesh.tets[t], survivor)) continue;
    for (const Index v : mesh.tets[t]) marks.set(v, kInRing);
  }
  for (const Index t : mesh.star(gone)) {
    const Tet& tet = mesh.tets[t];
    if (has_vertex(tet, survivor)) continue;
    std::array<Index, 3> ring{};
    std::size_t in_ring = 0;
    for (const Index v : tet) {
      if (v == gone) continue;
      const std::uint32_t mark = marks.of(v);
      if (mark == kInLinkOfKept) return false;  // a common neighbour that no tet joins with both
      if (mark == kInRing) ring[in_ring++] = v;
    }
    // Edges between ring vertices in the link of `gone` must be those of tets that have both ends, or be
    // missing in the link of `survivor`.
    for (std::size_t i = 0; i + 1 < in_ring; ++i) {
      for (std::size_t j = i + 1; j < in_ring; ++j) {
        bool in_both = false;
        bool in_link_of_survivor = false;
        for (const Index s : mesh.star(survivor)) {
          const Tet& other = mesh.tets[s];
          if (!has_vertex(other, ring[i]) || !has_vertex(other, ring[j])) continue;
          in_link_of_survivor = true;
          in_both = in_both || has_vertex(other, gone);
        }
        if (in_link_of_survivor && !in_both) return false;
      }
    }
  }
  return true;
}

}  // namespace palpate::simplify

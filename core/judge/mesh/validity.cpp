#include <algorithm>

#include "core/judge/mesh/exact_orientation.h"
#include "core/judge/mesh/judge.h"
#include "core/judge/mesh/vertex_links.h"

namespace palpate::judge {
namespace {

constexpr std::uint64_t kFindingsOfAKind = 3;

std::string number(Index element) {
  return std::to_string(std::uint64_t{element} + 1);
}

template <std::size_t N>
std::string numbers(std::array<Index, N> elements) {
  std::sort(elements.begin(), elements.end());
  std::string text;
  for (const Index element : elements) text += " " + number(element);
  return text;
}

std::string tets_of(LinkFace face) {
  std::string text = "tetrahedra";
  for (std::size_t i = 0; i < std::min<std::size_t>(face.size(), 4); ++i) text += " " + number(face[i].tet);
  return face.size() > 4 ? text + " ..." : text;
}

/// Counts one more of a kind and, for the first few, keeps the line that `text()` makes.
template <typename Text>
void add_finding(std::uint64_t& count, std::vector<std::string>& findings, Text&& text) {
  if (count++ < kFindingsOfAKind) findings.push_back(text());
}

void check_points(const TetMesh& mesh, Validity& result) {
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    if (is_finite(mesh.points[v])) continue;
    add_finding(result.non_finite_points, result.findings, [&] {
      return "vertex " + number(static_cast<Index>(v)) + ": a coordinate is NaN or infinite";
    });
  }
}

std::string describe_index_error(const Tet& tet, Index t, std::size_t points) {
  for (const Index v : tet) {
    if (v >= points) {
      return "tetrahedron " + number(t) + ": vertex " + number(v) + " does not exist, the mesh has " +
             std::to_string(points);
    }
  }
  return "tetrahedron " + number(t) + ": a vertex appears twice among" + numbers(tet);
}

/// Orientation of each tet; 0 for those that have none because of their indices or coordinates.
std::vector<std::int8_t> check_tets(const TetMesh& mesh, Validity& result) {
  std::vector<std::int8_t> signs(mesh.tets.size(), 0);
  const std::vector<Vec3>& p = mesh.points;
  for (std::size_t i = 0; i < mesh.tets.size(); ++i) {
    const Tet& t = mesh.tets[i];
    const Index name = static_cast<Index>(i);
    if (!has_valid_indices(t, p.size())) {
      add_finding(result.index_errors, result.findings,
                  [&] { return describe_index_error(t, name, p.size()); });
      continue;
    }
    if (!std::all_of(t.begin(), t.end(), [&](Index v) { return is_finite(p[v]); })) continue;
    const int sign = exact_orientation(p[t[0]], p[t[1]], p[t[2]], p[t[3]]);
    signs[i] = static_cast<std::int8_t>(sign);
    if (sign < 0) {
      add_finding(result.inverted_tets, result.findings,
                  [&] { return "tetrahedron " + number(name) + ": inverted (negative orientation)"; });
    } else if (sign == 0) {
      add_finding(result.flat_tets, result.findings,
                  [&] { return "tetrahedron " + number(name) + ": flat (its vertices lie in one plane)"; });
    }
  }
  return signs;
}

/// Everything that is read off the links of the vertices.
class LinkChecks {
 public:
  LinkChecks(const TetMesh& mesh, const Stars& stars, const std::vector<std::int8_t>& signs, Validity& result)
      : signs_(signs), result_(result), link_(mesh, stars) {}

  void check_vertex(Index vertex) {
    link_.move_to(vertex);
    if (link_.triangles() == 0) {
      add_finding(result_.isolated_vertices, result_.findings,
                  [&] { return "vertex " + number(vertex) + ": isolated, no tetrahedron uses it"; });
      return;
    }
    check_duplicates();
    join_across_faces();
    find_branching_vertices();
    check_link_surface();
  }

 private:
  /// Each tet is looked at from its least vertex.
  void check_duplicates() {
    opposite_.clear();
    for (std::size_t i = 0; i < link_.triangles(); ++i) {
      Triangle t = link_.triangle(i);
      std::sort(t.begin(), t.end());
      if (link_.vertex() < t[0]) opposite_.push_back({t, link_.star()[i]});
    }
    std::sort(opposite_.begin(), opposite_.end());
    std::size_t first = 0;
    for (std::size_t i = 1; i < opposite_.size(); ++i) {
      if (opposite_[i].first != opposite_[first].first) {
        first = i;
        continue;
      }
      add_finding(result_.duplicate_tets, result_.findings, [&] {
        return "tetrahedron " + number(opposite_[i].second) + ": the same vertices as tetrahedron " +
               number(opposite_[first].second);
      });
    }
  }

  /// Goes over the faces at the vertex: reports bad ones (from their least vertex) and joins, across faces
  /// with two or more tets, the link's triangles and the corners of triangles that meet.
  void join_across_faces() {
    const std::size_t triangles = link_.triangles();
    triangle_sets_.reset(triangles);
    corner_sets_.reset(3 * triangles);
    triangle_components_ = triangles;
    corner_components_ = 3 * triangles;
    faces_ = 0;
    boundary_faces_ = 0;
    branching_ends_.clear();
    link_.for_each_face([&](LinkFace face) {
      ++faces_;
      if (face.size() == 1) ++boundary_faces_;
      if (face.size() > 2) {
        branching_ends_.push_back(face[0].low);
        branching_ends_.push_back(face[0].high);
      }
      for (std::size_t i = 1; i < face.size(); ++i) join(face[0], face[i]);
      if (link_.vertex() < face[0].low) check_face(face);
    });
  }

  void join(const LinkSide& a, const LinkSide& b) {
    if (triangle_sets_.join(a.triangle, b.triangle)) --triangle_components_;
    for (const Index v : {a.low, a.high}) {
      if (corner_sets_.join(corner_of(a.triangle, v), corner_of(b.triangle, v))) --corner_components_;
    }
  }

  Index corner_of(Index triangle, Index vertex) const {
    const Triangle& t = link_.triangle(triangle);
    const Index place = t[0] == vertex ? 0 : (t[1] == vertex ? 1 : 2);
    return 3 * triangle + place;
  }

  void check_face(LinkFace face) {
    const Triangle vertices{link_.vertex(), face[0].low, face[0].high};
    if (face.size() > 2) {
      add_finding(result_.nonmanifold_faces, result_.findings, [&] {
        return "face" + numbers(vertices) + ": " + std::to_string(face.size()) + " tetrahedra have it (" +
               tets_of(face) + ")";
      });
    }
    if (face.size() != 2) return;
    const std::int8_t a = signs_[face[0].tet];
    const std::int8_t b = signs_[face[1].tet];
    if (a == 0 || b == 0 || (face[0].upward == (a > 0)) != (face[1].upward == (b > 0))) return;
    add_finding(result_.folded_faces, result_.findings, [&] {
      return "face" + numbers(vertices) + ": folded, " + tets_of(face) + " lie on the same side of it";
    });
  }

  /// Finds the link vertices around which the link is neither one cycle nor one path of triangles: those at
  /// a side of three or more triangles, and those whose corners fall into several sets.
  void find_branching_vertices() {
    branching_ = branching_ends_;
    if (corner_components_ != link_.vertices().size()) {
      roots_.clear();
      for (Index i = 0; i < 3 * link_.triangles(); ++i) {
        if (corner_sets_.root(i) == i) roots_.push_back(link_.triangle(i / 3)[i % 3]);
      }
      std::sort(roots_.begin(), roots_.end());
      for (std::size_t i = 1; i < roots_.size(); ++i) {
        if (roots_[i] == roots_[i - 1]) branching_.push_back(roots_[i]);
      }
    }
    std::sort(branching_.begin(), branching_.end());
    branching_.erase(std::unique(branching_.begin(), branching_.end()), branching_.end());
    for (const Index other : branching_) {
      if (link_.vertex() > other) continue;
      add_finding(result_.nonmanifold_edges, result_.findings, [&] {
        return "edge" + numbers(Edge{link_.vertex(), other}) +
               ": the tetrahedra around it make neither one ring nor one fan";
      });
    }
  }

  /// A connected surface without branching is a sphere when it is closed and its Euler characteristic is 2,
  /// and a disc when it has a rim and its Euler characteristic is 1.
  void check_link_surface() {
    const std::int64_t euler = static_cast<std::int64_t>(link_.vertices().size()) -
                               static_cast<std::int64_t>(faces_) +
                               static_cast<std::int64_t>(link_.triangles());
    const std::int64_t wanted = boundary_faces_ == 0 ? 2 : 1;
    if (branching_.empty() && triangle_components_ == 1 && euler == wanted) return;
    add_finding(result_.nonmanifold_vertices, result_.findings, [&] {
      return "vertex " + number(link_.vertex()) + ": its link is neither a sphere nor a disc";
    });
  }

  const std::vector<std::int8_t>& signs_;
  Validity& result_;
  VertexLink link_;

  std::vector<std::pair<Triangle, Index>> opposite_;
  DisjointSets triangle_sets_;
  DisjointSets corner_sets_;  // corner 3 i + k is vertex k of link triangle i
  std::size_t triangle_components_ = 0;
  std::size_t corner_components_ = 0;
  std::size_t faces_ = 0;
  std::size_t boundary_faces_ = 0;
  std::vector<Index> branching_ends_;
  std::vector<Index> branching_;
  std::vector<Index> roots_;
};

}  // namespace

bool Validity::is_valid() const {
  return index_errors == 0 && non_finite_points == 0 && inverted_tets == 0 && flat_tets == 0 &&
         duplicate_tets == 0 && nonmanifold_faces == 0 && folded_faces == 0 && nonmanifold_edges == 0 &&
         nonmanifold_vertices == 0 && isolated_vertices == 0;
}

Validity check_validity(const TetMesh& mesh) {
  Validity result;
  check_points(mesh, result);
  const std::vector<std::int8_t> signs = check_tets(mesh, result);
  const Stars stars = build_stars(mesh);
  LinkChecks checks(mesh, stars, signs, result);
  for (std::size_t v = 0; v < mesh.points.size(); ++v) checks.check_vertex(static_cast<Index>(v));
  return result;
}

}  // namespace palpate::judge

#include "core/mesh/subdivision/bisection.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <tuple>

#include "core/base/error.h"
#include "core/mesh/topology.h"

namespace palpate {
namespace {

/// Length squared, then the ends: which of two edges is longer.
using LengthRank = std::pair<double, Edge>;

class Bisector {
 public:
  Bisector(const TetMesh& mesh, const std::function<double(const Vec3&)>& size)
      : size_(size), out_{mesh, {}}, stars_(mesh.points.size()) {
    for (Index t = 0; t < mesh.tets.size(); ++t) {
      for (const Index v : mesh.tets[t]) stars_[v].push_back(t);
    }
    for (const Edge& edge : build_edges(mesh)) offer(edge);
  }

  BisectedMesh run(std::size_t vertices) {
    while (out_.mesh.points.size() < vertices && !queue_.empty()) {
      const Edge next = std::get<1>(queue_.top());
      if (tets_around(next).empty()) {
        queue_.pop();  // halved on the way
      } else {
        halve(end_of_path(next));  // the edge itself comes again until it is halved
      }
    }
    return std::move(out_);
  }

 private:
  const Vec3& at(Index v) const { return out_.mesh.points[v]; }
  LengthRank rank(const Edge& edge) const { return {length_sq(at(edge[1]) - at(edge[0])), edge}; }

  void offer(Edge edge) {
    if (edge[0] > edge[1]) std::swap(edge[0], edge[1]);
    const double size = size_(0.5 * (at(edge[0]) + at(edge[1])));
    require(size > 0.0, "bisect_edges: sizes above zero");
    if (std::isfinite(size)) queue_.push({std::sqrt(rank(edge).first) / size, edge});
  }

  std::vector<Index> tets_around(const Edge& edge) const {
    std::vector<Index> around;
    for (const Index t : stars_[edge[0]]) {
      const Tet& tet = out_.mesh.tets[t];
      if (std::find(tet.begin(), tet.end(), edge[1]) != tet.end()) around.push_back(t);
    }
    return around;
  }

  /// From an edge to the longest of the tets around it, until there is no longer one.
  Edge end_of_path(Edge edge) const {
    while (true) {
      LengthRank longest = rank(edge);
      for (const Index t : tets_around(edge)) {
        const Tet& tet = out_.mesh.tets[t];
        for (const auto& [i, j] : kTetEdges) {
          const Index a = tet[static_cast<std::size_t>(i)];
          const Index b = tet[static_cast<std::size_t>(j)];
          longest = std::max(longest, rank({std::min(a, b), std::max(a, b)}));
        }
      }
      if (longest.second == edge) return edge;
      edge = longest.second;
    }
  }

  void halve(const Edge& edge) {
    const auto [a, b] = edge;
    const auto middle = static_cast<Index>(out_.mesh.points.size());
    out_.mesh.points.push_back(0.5 * (at(a) + at(b)));
    out_.halved.push_back(edge);
    std::vector<Index> ring;
    std::vector<Index> star;
    for (const Index t : tets_around(edge)) {
      const auto half = static_cast<Index>(out_.mesh.tets.size());
      Tet second = out_.mesh.tets[t];
      for (const Index v : second) {
        if (v != a && v != b) {
          ring.push_back(v);
          stars_[v].push_back(half);
        }
      }
      std::replace(second.begin(), second.end(), a, middle);
      std::replace(out_.mesh.tets[t].begin(), out_.mesh.tets[t].end(), b, middle);
      out_.mesh.tets.push_back(second);
      std::replace(stars_[b].begin(), stars_[b].end(), t, half);
      star.insert(star.end(), {t, half});
    }
    stars_.push_back(std::move(star));
    std::sort(ring.begin(), ring.end());
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
    offer({a, middle});
    offer({b, middle});
    for (const Index v : ring) offer({v, middle});
  }

  const std::function<double(const Vec3&)>& size_;
  BisectedMesh out_;
  std::vector<std::vector<Index>> stars_;
  std::priority_queue<std::tuple<double, Edge>> queue_;
};

/// Halves a face that has the edge (a, b); false if it has not.
bool halve_face(const Edge& edge, Index middle, Triangle& face, Triangle& second) {
  const auto a = std::find(face.begin(), face.end(), edge[0]);
  const auto b = std::find(face.begin(), face.end(), edge[1]);
  if (a == face.end() || b == face.end()) return false;
  second = face;
  second[static_cast<std::size_t>(a - face.begin())] = middle;
  *b = middle;
  return true;
}

/// Halves the faces of a list that have the edge; `weights`, if there are any, go with them.
void halve_faces(const Edge& edge, Index middle, std::vector<Triangle>& faces, std::vector<double>* weights) {
  const std::size_t before = faces.size();
  Triangle second{};
  for (std::size_t f = 0; f < before; ++f) {
    if (!halve_face(edge, middle, faces[f], second)) continue;
    faces.push_back(second);
    if (weights != nullptr) weights->push_back((*weights)[f]);
  }
}

}  // namespace

BisectedMesh bisect_edges(const TetMesh& mesh, std::size_t vertices,
                          const std::function<double(const Vec3&)>& size) {
  return Bisector(mesh, size).run(vertices);
}

BoundaryProblem bisect_problem(const BoundaryProblem& problem, std::size_t vertices,
                               std::span<const Edge> halved) {
  if (!problem.body_force_n_m3.empty() || !problem.held_field_m.empty())
    throw InputError("problem", 0, "no body force or held displacement that varies, on another mesh", "one");
  BoundaryProblem out = problem;
  for (std::size_t i = 0; i < halved.size(); ++i) {
    const auto middle = static_cast<Index>(vertices + i);
    for (HeldFaces& held : out.held) halve_faces(halved[i], middle, held.faces, nullptr);
    for (ElasticSupport& support : out.supports)
      halve_faces(halved[i], middle, support.patch.faces, &support.patch.weight);
    for (Traction& traction : out.tractions)
      halve_faces(halved[i], middle, traction.patch.faces, &traction.patch.weight);
  }
  return out;
}

}  // namespace palpate

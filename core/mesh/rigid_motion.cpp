#include "core/mesh/rigid_motion.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "core/base/error.h"

namespace palpate {
namespace {

using Motions = Eigen::MatrixXd;  // a column each

constexpr double kFree = 1e-10;
constexpr double kLeastTurn = 1e-4;  // a free motion, of length 1, that turns less is a translation

/// The connected part of each vertex, numbered in the order of their smallest vertices.
struct Parts {
  std::vector<Index> of_vertex;
  std::vector<Index> smallest;
};

Parts find_parts(const TetMesh& mesh) {
  std::vector<Index> parent(mesh.points.size());
  std::iota(parent.begin(), parent.end(), Index{0});
  const auto root = [&](Index v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const Tet& tet : mesh.tets) {
    for (std::size_t k = 1; k < 4; ++k) {
      const Index a = root(tet[0]);
      const Index b = root(tet[k]);
      parent[std::max(a, b)] = std::min(a, b);
    }
  }
  Parts parts{std::vector<Index>(parent.size()), {}};
  for (Index v = 0; v < parent.size(); ++v) {
    const Index smallest = root(v);
    if (smallest == v) {
      parts.of_vertex[v] = static_cast<Index>(parts.smallest.size());
      parts.smallest.push_back(v);
    } else {
      parts.of_vertex[v] = parts.of_vertex[smallest];
    }
  }
  return parts;
}

/// One part: where it is, and sum of n n^T over the rows n of the resisted axes, by which a vertex at p moves
/// n . (t, w) under the translation t and the rotation w x (p - center) / radius.
struct Part {
  Vec3 center;
  double radius = 0.0;
  std::size_t vertices = 0;
  Eigen::MatrixXd resistance = Eigen::MatrixXd::Zero(6, 6);

  void resist(const Vec3& point, std::uint8_t axes) {
    const Vec3 r = (1.0 / radius) * (point - center);
    Eigen::Matrix<double, 3, 6> rows;
    rows << 1, 0, 0, 0, r.z, -r.y, 0, 1, 0, -r.z, 0, r.x, 0, 0, 1, r.y, -r.x, 0;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      if (((static_cast<unsigned>(axes) >> axis) & 1U) != 0)
        resistance += rows.row(axis).transpose() * rows.row(axis);
    }
  }
};

/// Adds an orthonormal basis of the columns' span, each vector as near to one coordinate as can be: the
/// longest projection of a unit vector on what is left comes first.
void add_plain_basis(Motions left, std::vector<Eigen::VectorXd>& basis) {
  while (left.cols() > 0) {
    const Eigen::MatrixXd projection = left * left.transpose();
    Eigen::Index nearest = 0;
    for (Eigen::Index k = 1; k < 6; ++k) {
      if (projection(k, k) > projection(nearest, nearest) + 1e-9) nearest = k;
    }
    const Eigen::VectorXd next = projection.col(nearest).normalized();
    basis.push_back(next);
    // What is left: the orthogonal complement of `next` in the span.
    const Eigen::VectorXd inside = left.transpose() * next;
    const Eigen::MatrixXd rest =
        Eigen::MatrixXd::Identity(left.cols(), left.cols()) - inside * inside.transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(rest);
    left = Motions(left * eigen.eigenvectors().rightCols(left.cols() - 1));
  }
}

/// The motions that the part's resistance leaves free, translations first.
std::vector<Eigen::VectorXd> free_motions(const Part& part) {
  const double size = part.resistance.trace();
  if (!(size > 0.0)) {
    std::vector<Eigen::VectorXd> all;
    for (Eigen::Index k = 0; k < 6; ++k) all.push_back(Eigen::VectorXd::Unit(6, k));
    return all;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(part.resistance / size);
  const Eigen::Index count = (eigen.eigenvalues().array() <= kFree).count();
  const Motions free = eigen.eigenvectors().leftCols(count);
  std::vector<Eigen::VectorXd> basis;
  if (count == 0) return basis;
  // Combinations without rotation are translations; what is orthogonal to them turns.
  const Eigen::MatrixXd turning = free.bottomRows(3).transpose() * free.bottomRows(3);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> split(turning);
  const Eigen::Index still = (split.eigenvalues().array() <= kLeastTurn * kLeastTurn).count();
  add_plain_basis(free * split.eigenvectors().leftCols(still), basis);
  add_plain_basis(free * split.eigenvectors().rightCols(count - still), basis);
  return basis;
}

RigidMotion named(const Eigen::VectorXd& motion, Index name, const Part& part) {
  const Vec3 shift{motion[0], motion[1], motion[2]};
  const Vec3 turn{motion[3], motion[4], motion[5]};
  if (length(turn) < kLeastTurn) return {name, false, (1.0 / length(shift)) * shift, {}};
  const Vec3 point = part.center + (part.radius / length_sq(turn)) * cross(turn, shift);
  return {name, true, (1.0 / length(turn)) * turn, point};
}

std::string vector_text(const Vec3& v) {
  std::array<char, 96> text{};
  // Adding zero turns the -0 that rounding leaves into 0.
  const auto round = [](double x) { return std::round(1e4 * x) / 1e4 + 0.0; };
  std::snprintf(text.data(), text.size(), "(%g, %g, %g)", round(v.x), round(v.y), round(v.z));
  return text.data();
}

}  // namespace

std::vector<std::uint8_t> resisted_axes(const TetMesh& mesh, const BoundaryProblem& problem) {
  std::vector<std::uint8_t> axes(mesh.points.size(), 0);
  for (const HeldFaces& held : problem.held) {
    unsigned bits = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) bits |= held.axes[axis] ? 1U << axis : 0U;
    for (const Triangle& face : held.faces) {
      for (const Index v : face) axes[v] = static_cast<std::uint8_t>(axes[v] | bits);
    }
  }
  for (const ElasticSupport& support : problem.supports) {
    for (std::size_t f = 0; f < support.patch.faces.size(); ++f) {
      const Triangle& face = support.patch.faces[f];
      const Vec3& a = mesh.points[face[0]];
      const double area = length(cross(mesh.points[face[1]] - a, mesh.points[face[2]] - a));
      if (!(support.stiffness_pa_per_m * support.patch.weight[f] * area > 0.0)) continue;
      for (const Index v : face) axes[v] = 7;
    }
  }
  return axes;
}

std::vector<RigidMotion> find_free_motions(const TetMesh& mesh, std::span<const std::uint8_t> resisted) {
  require(resisted.size() == mesh.points.size(), "find_free_motions: one entry a vertex");
  const Parts found = find_parts(mesh);
  const std::vector<Index>& part_of = found.of_vertex;
  std::vector<Part> parts(found.smallest.size());
  for (Index v = 0; v < part_of.size(); ++v) {
    Part& part = parts[part_of[v]];
    part.center = part.center + mesh.points[v];
    ++part.vertices;
  }
  for (Part& part : parts) part.center = (1.0 / static_cast<double>(part.vertices)) * part.center;
  for (Index v = 0; v < part_of.size(); ++v) {
    Part& part = parts[part_of[v]];
    part.radius = std::max(part.radius, length(mesh.points[v] - part.center));
  }
  for (Index v = 0; v < part_of.size(); ++v) {
    if (resisted[v] != 0 && parts[part_of[v]].radius > 0.0)
      parts[part_of[v]].resist(mesh.points[v], resisted[v]);
  }
  std::vector<RigidMotion> free;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    if (parts[p].vertices < 4) continue;  // a vertex of no tet
    for (const Eigen::VectorXd& motion : free_motions(parts[p]))
      free.push_back(named(motion, found.smallest[p], parts[p]));
  }
  return free;
}

std::string rigid_motion_text(const RigidMotion& motion) {
  const std::string axis = vector_text(motion.axis);
  return motion.is_rotation ? "a rotation about " + axis + " through " + vector_text(motion.point) + " m"
                            : "a translation along " + axis;
}

}  // namespace palpate

#include "reference/fenicsx/rigid_motions.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <numeric>

#include "core/base/error.h"

namespace palpate::reference::fenicsx {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Motion = Eigen::Matrix<double, 3, 6>;

/// The displacement at `p` of three translations and three rotations about `center`, over `radius`.
Motion motion_at(const Vec3& p, const Vec3& center, double radius) {
  const Vec3 r = (1.0 / radius) * (p - center);
  Motion m;
  m << 1, 0, 0, 0, r.z, -r.y, 0, 1, 0, -r.z, 0, r.x, 0, 0, 1, r.y, -r.x, 0;
  return m;
}

/// The connected part of each vertex, named by one of its vertices.
std::vector<Index> parts_of(const TetMesh& mesh) {
  std::vector<Index> part(mesh.points.size());
  std::iota(part.begin(), part.end(), Index{0});
  const auto root = [&](Index v) {
    while (part[v] != v) v = part[v] = part[part[v]];
    return v;
  };
  for (const Tet& t : mesh.tets) {
    for (std::size_t i = 1; i < 4; ++i) part[root(t[i])] = root(t[0]);
  }
  for (Index v = 0; v < part.size(); ++v) part[v] = root(v);
  return part;
}

/// What holds one connected part, as a quadratic form on its rigid motions.
struct Hold {
  Vec3 center;
  double radius = 0.0;
  std::size_t vertices = 0;
  Matrix6 form = Matrix6::Zero();
};

constexpr double kFree = 1e-12;  // of the greatest eigenvalue: a rigid motion that costs less is free

}  // namespace

void require_no_free_motion(const TetMesh& mesh, const BoundaryProblem& problem) {
  const std::vector<Index> part = parts_of(mesh);
  std::vector<Hold> holds(mesh.points.size());
  for (Index v = 0; v < part.size(); ++v) {
    Hold& hold = holds[part[v]];
    hold.center = hold.center + mesh.points[v];
    ++hold.vertices;
  }
  for (Hold& hold : holds) {
    if (hold.vertices > 0) hold.center = (1.0 / static_cast<double>(hold.vertices)) * hold.center;
  }
  for (Index v = 0; v < part.size(); ++v) {
    Hold& hold = holds[part[v]];
    hold.radius = std::max(hold.radius, length(mesh.points[v] - hold.center));
  }
  const auto add = [&](const Triangle& face, const std::array<bool, 3>& axes) {
    for (const Index v : face) {
      Hold& hold = holds[part[v]];
      const Motion m = motion_at(mesh.points[v], hold.center, hold.radius);
      for (int axis = 0; axis < 3; ++axis) {
        if (axes[static_cast<std::size_t>(axis)]) hold.form += m.row(axis).transpose() * m.row(axis);
      }
    }
  };
  for (const HeldFaces& held : problem.held) {
    for (const Triangle& face : held.faces) add(face, held.axes);
  }
  for (const ElasticSupport& support : problem.supports) {
    for (const Triangle& face : support.patch.faces) add(face, {true, true, true});
  }
  for (const Hold& hold : holds) {
    if (hold.vertices < 4) continue;
    const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(hold.form, Eigen::EigenvaluesOnly);
    const auto& values = eigen.eigenvalues();
    const auto free = (values.array() <= kFree * std::max(values[5], 1e-300)).count();
    if (free > 0) {
      throw InputError("problem", 0, "supports or held faces that stop every rigid motion",
                       std::to_string(free) + (free == 1 ? " motion" : " motions") + " left free");
    }
  }
}

NullSpace near_null_space(const TetMesh& mesh, const ElasticBody& body) {
  const auto [least, most] = std::minmax_element(mesh.points.begin(), mesh.points.end(),
                                                 [](const Vec3& a, const Vec3& b) { return a.x < b.x; });
  const Vec3 center = mesh.points[mesh.points.size() / 2];
  const double radius = std::max(most->x - least->x, 1e-300);
  std::array<Vector, 6> motions;
  for (int k = 0; k < 6; ++k) {
    Vector& motion = motions[static_cast<std::size_t>(k)];
    motion = body.create_vector();
    const LocalEntries entries(motion.get());
    for (std::size_t node = 0; node < body.nodes().size(); ++node) {
      const auto [a, b] = body.nodes()[node];
      const Motion m = motion_at(0.5 * (mesh.points[a] + mesh.points[b]), center, radius);
      for (int axis = 0; axis < 3; ++axis) entries[3 * node + static_cast<std::size_t>(axis)] = m(axis, k);
    }
  }
  for (std::size_t k = 0; k < 6; ++k) {  // modified Gram-Schmidt
    for (std::size_t j = 0; j < k; ++j) {
      PetscScalar overlap = 0.0;
      check(VecDot(motions[k].get(), motions[j].get(), &overlap), "VecDot");
      check(VecAXPY(motions[k].get(), -overlap, motions[j].get()), "VecAXPY");
    }
    check(VecNormalize(motions[k].get(), nullptr), "VecNormalize");
  }
  std::array<Vec, 6> basis{};
  for (std::size_t k = 0; k < 6; ++k) basis[k] = motions[k].get();
  NullSpace made;
  check(MatNullSpaceCreate(PETSC_COMM_WORLD, PETSC_FALSE, 6, basis.data(), made.put()), "MatNullSpaceCreate");
  return made;
}

}  // namespace palpate::reference::fenicsx

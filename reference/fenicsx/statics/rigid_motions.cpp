#include "reference/fenicsx/statics/rigid_motions.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>

#include "core/base/error.h"
#include "core/mesh/rigid_motion.h"

namespace palpate::reference::fenicsx {
namespace {

using Motion = Eigen::Matrix<double, 3, 6>;

/// The displacement at `p` of three translations and three rotations about `center`, over `radius`.
Motion motion_at(const Vec3& p, const Vec3& center, double radius) {
  const Vec3 r = (1.0 / radius) * (p - center);
  Motion m;
  m << 1, 0, 0, 0, r.z, -r.y, 0, 1, 0, -r.z, 0, r.x, 0, 0, 1, r.y, -r.x, 0;
  return m;
}

}  // namespace

void require_no_free_motion(const TetMesh& mesh, const BoundaryProblem& problem) {
  const std::vector<RigidMotion> free = find_free_motions(mesh, resisted_axes(mesh, problem));
  if (free.empty()) return;
  throw InputError("problem", 0, "supports or held faces that stop every rigid motion",
                   std::to_string(free.size()) + (free.size() == 1 ? " motion" : " motions") +
                       " left free, such as " + rigid_motion_text(free[0]));
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

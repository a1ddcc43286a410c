// Linear elasticity on linear tets, as plainly as it goes, and a smooth solution of it: for tests that need a
// true sequence of finite element answers.
#pragma once

#include <vector>

#include "core/base/types.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::testing_support {

/// Lame's parameters, in Pa.
struct LameParameters {
  double lambda_pa = 1.0;
  double mu_pa = 1.0;
};

/// A smooth displacement field, u = (sin 2x cos 2y, sin 2y cos 2z, sin 2z cos 2x).
Vec3 smooth_displacement(const Vec3& p);

/// The force a unit of volume that holds a body in smooth_displacement: -div(stress).
Vec3 smooth_body_force(const Vec3& p, const LameParameters& material);

/// Solves for smooth_body_force(., loaded_as) with the stiffness of `material` and smooth_displacement held
/// on all boundary vertices, by conjugate gradients. With loaded_as = material the error falls as h^2.
std::vector<Vec3> solve_smooth_problem(const TetMesh& mesh, const LameParameters& material,
                                       const LameParameters& loaded_as);

}  // namespace palpate::testing_support

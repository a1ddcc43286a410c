// One modulus, scaled so that a coarse space gives what quadratic elements on the whole mesh give.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/dynamics/linear_algebra/sparse_factor.h"
#include "reference/mixed_order/solid_system.h"

namespace palpate::reference {

/// What came of the fit.
struct ModulusFit {
  double scale = 1.0;
  double off_before = 0.0;  ///< relative deformation off, over the three loads together, with the scale 1
  double off_after = 0.0;
  int rounds = 0;
};

/// A field of the space's nodes at the vertices of the organ's mesh.
using SampleVertices = std::function<std::vector<Vec3>(std::span<const Vec3> all_m)>;

/// What is fitted to what.
struct FitTask {
  const TetMesh& organ;
  const BoundaryProblem& problem;  ///< on the organ's mesh
  const SolidSpace& model;
  const BoundaryProblem& model_problem;  ///< on the model's
};

/// The factor s of Young's modulus for which a model is nearest, in the deformation at the organ's vertices,
/// to quadratic elements on the whole mesh under its weight along x, y and z on the scene's own supports:
///
///   min over s of sum over the three of |P (u - u_s)|^2,   (s K + S) u_s = f
///
/// by Gauss and Newton's method, d u_s / ds = -(s K + S)^-1 K u_s; P takes the best rigid motion off.
/// Throws: UnavailableError if no positive factor is found.
ModulusFit fit_modulus(const FitTask& task, const SampleVertices& sample,
                       const dynamics::FactorMaker& make_factor);

}  // namespace palpate::reference

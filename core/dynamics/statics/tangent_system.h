// One step of Newton's method: the tangent of model, supports and volume force, and solves with it.
#pragma once

#include <span>
#include <vector>

#include "core/dynamics/elasticity/elastic_model.h"
#include "core/dynamics/elasticity/loads.h"
#include "core/dynamics/elasticity/tangent.h"
#include "core/dynamics/linear_algebra/linear_solver.h"

namespace palpate::dynamics {

/// The tangent at one displacement. The volume force's part is a product of a few vectors, which the sparse
/// matrix leaves out: with A = K + turning, U = (turning axes, k d), V = (center weights, volume gradient),
/// (A - U V^T) x = b is x = y + Y (I - V^T Y)^-1 V^T y, A y = b, A Y = U (Woodbury).
class TangentSystem {
 public:
  TangentSystem(const ElasticModel& model, const Loads& loads, const LinearOptions& options);

  /// Sets up the tangent at `displacement`. `shift` x the mean diagonal is added to the diagonal.
  /// Returns: kIndefinite where a factorisation met a pivot <= 0.
  LinearStatus prepare(std::span<const Vec3> displacement, TangentKind kind, double shift);

  /// Solves for the free components; those that are held become zero.
  LinearResult solve(std::span<const Vec3> b, double tolerance, std::span<Vec3> x);

  /// y = tangent x, in all components.
  void apply(std::span<const Vec3> x, std::span<Vec3> y) const;

  bool is_direct() const { return solver_.is_direct(); }
  /// The volume force's part makes the whole not symmetric.
  bool is_symmetric() const { return !model_->volume_force.has_value(); }

 private:
  void add_volume_part(std::span<const Vec3> displacement);

  const ElasticModel* model_;
  const Loads* loads_;
  LinearOptions options_;
  BlockMatrix matrix_;
  LinearSolver solver_;
  std::vector<std::vector<Vec3>> left_;   ///< U
  std::vector<std::vector<Vec3>> right_;  ///< V
};

}  // namespace palpate::dynamics

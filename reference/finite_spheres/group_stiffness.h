// Stiffness of linear elasticity, summed up from gradients, group of functions by group.
#pragma once

#include <span>
#include <vector>

#include "core/dynamics/linear_algebra/block_matrix.h"
#include "core/mesh/boundary_problem.h"
#include "reference/finite_spheres/functions.h"

namespace palpate::reference {

/// The zero matrix of the coefficients. `groups` holds places of spheres; each pair within a group may meet.
dynamics::BlockMatrix build_sphere_matrix(std::size_t spheres, std::size_t per_sphere,
                                          const dynamics::VertexGroups& groups);

/// Sums the stiffness of one group of functions over its points,
///   K_ab = sum of w (lambda g_a g_b^T + mu (g_b g_a^T + (g_a . g_b) I)),
/// and adds it to the upper half of a matrix.
class GroupStiffness {
 public:
  explicit GroupStiffness(const Material& material)
      : lambda_pa_(material.lambda_pa()), mu_pa_(material.mu_pa()) {}

  /// Starts with the spheres of a group: their places, increasing, and how many functions each has.
  void start(std::span<const Index> spheres, std::size_t per_sphere);

  /// Adds a point: gradients in 1/m with the numbers of their coefficients, each within the group; weight in
  /// m^3.
  void add(std::span<const Index> numbers, std::span<const Vec3> gradients, double weight);

  /// Adds what was summed up. The numbers are increasing, so a <= b is the upper half.
  void add_to_upper(dynamics::BlockMatrix& matrix);

 private:
  double lambda_pa_;
  double mu_pa_;
  std::vector<Index> numbers_;     ///< of the group's coefficients
  std::vector<double> gradients_;  ///< a row of 3 x numbers_ a point
  std::vector<double> weights_;
  std::vector<double> products_;
};

/// Adds `block` at (a, b) of the upper half: its transpose at (b, a) if a > b.
void add_upper(dynamics::BlockMatrix& matrix, Index a, Index b, const dynamics::Mat3& block);

/// Copies the upper half to the lower one. Linear time.
void mirror_upper(dynamics::BlockMatrix& matrix);

}  // namespace palpate::reference

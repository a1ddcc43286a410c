// The lowest modes of a finite-element body in its holding, and its static answers to loads.
#pragma once

#include <span>
#include <vector>

#include "core/dynamics/finite_elements/node_loads.h"
#include "core/dynamics/linear_algebra/sparse_factor.h"

namespace palpate::dynamics {

/// Modes K x = omega^2 M x of the held body, consistent mass; x^T M x = 1.
///
/// Shape:  squares_per_s2 rises; a mode has one vector a node, zero where it is held.
struct LowestModes {
  std::vector<double> squares_per_s2;
  std::vector<std::vector<Vec3>> modes;
};

/// A body on supports, factored: its modes, and its answers to loads at rest.
class HeldElements {
 public:
  /// `body` must outlive it. `support_stiffness` has the pattern of the body: it with its supports.
  HeldElements(const ElementMatrices& body, BlockMatrix with_supports, std::vector<std::uint8_t> held,
               const FactorMaker& make_factor);

  /// The `count` lowest. Spectra's restarted Lanczos method on (K + S)^-1 M, to a residual of 1e-10.
  /// Throws: InputError for none or more than the body has; UnavailableError if it does not converge.
  LowestModes find_modes(std::size_t count) const;

  /// The displacement at rest under `force`, with held components at `held_by`.
  std::vector<Vec3> rest_under(std::span<const Vec3> force, std::span<const Vec3> held_by) const;

  const BlockMatrix& stiffness() const { return stiffness_; }
  /// The factor, and how many free components it has.
  const SymmetricFactor& factor() const { return *factor_; }
  std::size_t unknowns() const { return free_.count; }

 private:
  const ElementMatrices& body_;
  BlockMatrix stiffness_;
  std::vector<std::uint8_t> held_;
  FreeNumbers free_;
  std::unique_ptr<SymmetricFactor> factor_;
};

}  // namespace palpate::dynamics

// Linear elements with a few fields of a finer space beside them.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/dynamics/finite_elements/node_map.h"
#include "core/dynamics/reduced/modal_basis.h"

namespace palpate::dynamics {

/// The body at rest in the space of T (linear elements, say) and of given fields e_i of the finer one, by
/// Galerkin's method with the finer one's stiffness K, supports included:
///
///   u = T a + sum c_i z_i,   z_i = e_i - T (T^T K T)^-1 T^T K e_i,  turned so that z_i . K z_j = delta_ij
///   a = (T^T K T)^-1 T^T f,  c_i = z_i . f
///
/// (with held components that are moved: f - K T a in place of f). The spaces are nested, so the energy of
/// the error is no more than that without the fields, on whatever supports the fields were found.
class EnrichedElements {
 public:
  /// `coarse` (T^T K T, factored), `map` and `fine` (K) must outlive it. Fields must be zero where the body
  /// is held. Throws: UnavailableError if the fields depend on each other and on the linear functions.
  EnrichedElements(const HeldElements& coarse, const NodeMap& map, const BlockMatrix& fine,
                   std::span<const std::vector<Vec3>> fields);

  /// The displacement of all nodes of the finer space. Shape: force_n one entry a node of it, held_by_m one
  /// an unknown of the map.
  std::vector<Vec3> rest_under(std::span<const Vec3> force_n, std::span<const Vec3> held_by_m) const;

  /// The z_i.
  const std::vector<std::vector<Vec3>>& fields() const { return fields_; }

 private:
  const HeldElements& coarse_;
  const NodeMap& map_;
  const BlockMatrix& fine_;
  std::vector<std::vector<Vec3>> fields_;
};

}  // namespace palpate::dynamics

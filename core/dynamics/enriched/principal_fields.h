// The few fields that many fields are nearest to.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "core/base/types.h"

namespace palpate::dynamics {

/// Proper orthogonal decomposition.
///
/// Shape:  fields have the size of the samples, u_i . M u_j = delta_ij; shares falls: what part of the sum of
///         all u . M u each of them holds.
struct PrincipalFields {
  std::vector<std::vector<Vec3>> fields;
  std::vector<double> shares;
};

/// y = M x, symmetric and positive semidefinite.
using FieldProduct = std::function<void(std::span<const Vec3> x, std::span<Vec3> y)>;

/// The `count` combinations of the samples that leave least of them in the mean square of M, by the
/// eigenvectors of their Gram matrix. Fewer where the samples have fewer independent parts (to 1e-12 of the
/// first). Memory: the samples once more. Throws: ContractError for samples of different sizes.
/// Source: L. Sirovich, Quarterly of Applied Mathematics 45 (1987), 561-571 (the method of snapshots).
PrincipalFields find_principal_fields(std::span<const std::vector<Vec3>> samples, const FieldProduct& product,
                                      std::size_t count);

}  // namespace palpate::dynamics

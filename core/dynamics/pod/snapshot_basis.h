// A basis of displacements by proper orthogonal decomposition of snapshots.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/base/types.h"

namespace palpate::dynamics {

/// Orthonormal displacements.
///
/// Shape:  shapes has three rows a vertex (x, y, z) and a column a shape; singular_values all that the
///         snapshots have, falling.
struct SnapshotBasis {
  Eigen::MatrixXd shapes;
  std::vector<double> singular_values;
};

/// The left singular vectors of the snapshots that belong to the largest singular values: at most `most`, and
/// no more than leave `tolerance` of the root of the sum of squares out. No mean is taken off, so that the
/// body at rest is in the basis.
///
/// Throws: InputError for no snapshot, snapshots of unlike lengths, or none that moves.
/// Source: L. Sirovich, Quart. Appl. Math. 45 (1987), 561-571.
SnapshotBasis find_snapshot_basis(std::span<const std::vector<Vec3>> snapshots, std::size_t most,
                                  double tolerance);

/// What a basis leaves out of a displacement, over its size: |u - B B^T u| / |u|.
double left_out_of(const SnapshotBasis& basis, std::span<const Vec3> u);

/// Throws InputError for a basis that does not fit the body: another number of vertices, shapes that are not
/// orthonormal to 1e-8 or not finite, or one that moves a held component (bit i of `held`: axis i).
/// `where` names what it came from.
void require_basis(const SnapshotBasis& basis, std::span<const std::uint8_t> held,
                   const std::string& where = "basis");

/// B^T u.
Eigen::VectorXd coordinates_of(const SnapshotBasis& basis, std::span<const Vec3> u);
/// B q.
std::vector<Vec3> displacement_of(const SnapshotBasis& basis, const Eigen::VectorXd& q);

}  // namespace palpate::dynamics

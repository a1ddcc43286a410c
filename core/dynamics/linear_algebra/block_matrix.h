// Symmetric sparse matrices of 3 x 3 blocks, one row a vertex, in compressed rows.
#pragma once

#include <span>
#include <vector>

#include "core/dynamics/linear_algebra/matrix3.h"

namespace palpate::dynamics {

/// A square matrix of blocks; both halves are stored.
///
/// Shape:  offsets has one entry a row and one more; columns (increasing within a row, the diagonal always
///         among them) and blocks hold the entries offsets[v] .. offsets[v + 1] of row v.
struct BlockMatrix {
  std::vector<std::size_t> offsets{0};
  std::vector<Index> columns;
  std::vector<Mat3> blocks;

  std::size_t rows() const { return offsets.size() - 1; }
};

/// Groups of vertices in compressed rows: each vertex of a group meets each other one in the matrix.
struct VertexGroups {
  std::span<const Index> offsets;
  std::span<const Index> vertices;
};

/// The zero matrix whose pattern holds the diagonal and the pairs within each group.
BlockMatrix build_block_matrix(std::size_t rows, std::span<const VertexGroups> groups);

/// Adds `block` at (row, column). Throws: ContractError if the pattern lacks it.
void add_block(BlockMatrix& matrix, Index row, Index column, const Mat3& block);

/// Makes the blocks below the diagonal the transposes of those above it.
void mirror_upper_half(BlockMatrix& matrix);

/// y = A x. Any number of threads gives the same.
void multiply(const BlockMatrix& matrix, std::span<const Vec3> x, std::span<Vec3> y, int threads = 1);

}  // namespace palpate::dynamics

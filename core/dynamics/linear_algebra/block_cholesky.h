// Incomplete Cholesky factorisation by blocks: a preconditioner of conjugate gradients.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/dynamics/linear_algebra/block_matrix.h"

namespace palpate::dynamics {

/// L D L^T on the pattern of the lower half of a matrix, by 3 x 3 blocks. Where a diagonal block would not
/// stay positive definite, the matrix's diagonal is raised and the factorisation starts again.
///
/// Shape:  offsets, columns, blocks hold the rows of L below the diagonal, in single precision, which halves
///         what each application reads; inverse_diagonal the blocks of D^-1.
struct BlockCholesky {
  std::vector<std::size_t> offsets;
  std::vector<Index> columns;
  std::vector<std::array<float, 9>> blocks;
  std::vector<Mat3> inverse_diagonal;
  double shift = 0.0;  ///< share of the diagonal that was added
};

/// Factors `matrix` without the held components (bit i of held[v]: axis i). `drop` leaves out blocks whose
/// norm is below drop x the geometric mean of the diagonal blocks' norms; 0 keeps the whole pattern.
BlockCholesky factor_incomplete(const BlockMatrix& matrix, std::span<const std::uint8_t> held, double drop);

/// x = (L D L^T)^-1 b.
void apply_inverse(const BlockCholesky& factor, std::span<const Vec3> b, std::span<Vec3> x);

}  // namespace palpate::dynamics

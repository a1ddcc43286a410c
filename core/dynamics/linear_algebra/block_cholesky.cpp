#include "core/dynamics/linear_algebra/block_cholesky.h"

#include <algorithm>
#include <cmath>

namespace palpate::dynamics {
namespace {

/// The inverse of a symmetric block, if it is positive definite with some room.
bool invert_positive(const Mat3& a, Mat3& inverse) {
  const double scale = trace(a) / 3.0;
  const double minor = a(0, 0) * a(1, 1) - a(0, 1) * a(1, 0);
  const double det = determinant(a);
  constexpr double kRoom = 1e-6;
  if (!(scale > 0.0) || !(a(0, 0) > kRoom * scale) || !(minor > kRoom * scale * scale) ||
      !(det > kRoom * scale * scale * scale))
    return false;
  inverse = (1.0 / det) * transpose(cofactors(a));
  return true;
}

/// Rows and columns of held axes become those of the identity on the diagonal, and zero elsewhere.
Mat3 mask(Mat3 block, unsigned row_held, unsigned column_held, bool is_diagonal) {
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      if (((row_held >> i) & 1U) != 0 || ((column_held >> j) & 1U) != 0)
        block(i, j) = is_diagonal && i == j ? 1.0 : 0.0;
    }
  }
  return block;
}

double norm(const Mat3& a) {
  return std::sqrt(contract(a, a));
}

/// Rows below the diagonal, in full precision while they are worked on.
struct Lower {
  std::vector<std::size_t> offsets{0};
  std::vector<Index> columns;
  std::vector<Mat3> blocks;
};

/// The lower half of the matrix, held components masked, small blocks dropped.
Lower copy_lower(const BlockMatrix& matrix, std::span<const std::uint8_t> held, double drop,
                 std::vector<Mat3>& diagonal) {
  Lower out;
  diagonal.resize(matrix.rows());
  std::vector<double> size(matrix.rows());
  for (Index v = 0; v < matrix.rows(); ++v) {
    for (std::size_t k = matrix.offsets[v]; matrix.columns[k] <= v; ++k) {
      const Index c = matrix.columns[k];
      const Mat3 block = mask(matrix.blocks[k], held[v], held[c], c == v);
      if (c == v) {
        diagonal[v] = block;
        size[v] = norm(block);
        break;
      }
      const double norm_sq = contract(block, block);
      if (norm_sq == 0.0) continue;
      out.columns.push_back(c);
      out.blocks.push_back(block);
    }
    if (drop > 0.0) {
      std::size_t kept = out.offsets.back();
      for (std::size_t k = kept; k < out.columns.size(); ++k) {
        const double bound = drop * drop * size[v] * size[out.columns[k]];
        if (contract(out.blocks[k], out.blocks[k]) < bound) continue;
        out.columns[kept] = out.columns[k];
        out.blocks[kept++] = out.blocks[k];
      }
      out.columns.resize(kept);
      out.blocks.resize(kept);
    }
    out.offsets.push_back(out.columns.size());
  }
  return out;
}

/// One try, row by row: L_vc = (A_vc - sum over d < c of L_vd D_d L_cd^T) D_c^-1.
bool try_factor(Lower& factor, std::vector<Mat3>& diagonal, std::vector<Mat3>& inverse_diagonal) {
  const std::size_t rows = diagonal.size();
  std::vector<std::size_t> place(rows, 0);  // of column c in the present row, plus one
  inverse_diagonal.assign(rows, {});
  std::vector<Mat3> scaled;  // L_vd D_d of the present row
  for (std::size_t v = 0; v < rows; ++v) {
    const std::size_t first = factor.offsets[v];
    const std::size_t last = factor.offsets[v + 1];
    for (std::size_t k = first; k < last; ++k) place[factor.columns[k]] = k - first + 1;
    scaled.assign(factor.blocks.begin() + static_cast<std::ptrdiff_t>(first),
                  factor.blocks.begin() + static_cast<std::ptrdiff_t>(last));
    for (std::size_t k = first; k < last; ++k) {
      const Index c = factor.columns[k];
      Mat3& entry = scaled[k - first];
      for (std::size_t m = factor.offsets[c]; m < factor.offsets[c + 1]; ++m) {
        const std::size_t other = place[factor.columns[m]];
        if (other == 0) continue;
        entry += (-1.0) * multiply(scaled[other - 1], transpose(factor.blocks[m]));
      }
      factor.blocks[k] = multiply(entry, inverse_diagonal[c]);
      diagonal[v] += (-1.0) * multiply(factor.blocks[k], transpose(entry));
    }
    for (std::size_t k = first; k < last; ++k) place[factor.columns[k]] = 0;
    const Mat3 symmetric = 0.5 * (diagonal[v] + transpose(diagonal[v]));
    if (!invert_positive(symmetric, inverse_diagonal[v])) return false;
  }
  return true;
}

}  // namespace

BlockCholesky factor_incomplete(const BlockMatrix& matrix, std::span<const std::uint8_t> held, double drop) {
  std::vector<Mat3> diagonal;
  const Lower lower = copy_lower(matrix, held, drop, diagonal);
  double mean = 0.0;
  for (const Mat3& block : diagonal) mean += std::abs(trace(block)) / 3.0;
  mean /= static_cast<double>(std::max<std::size_t>(diagonal.size(), 1));
  constexpr double kFirstShift = 1e-3;
  constexpr int kMostTries = 21;  // the last shift is 524 x the diagonal
  BlockCholesky factor;
  for (int attempt = 0; attempt < kMostTries; ++attempt) {
    const double shift = attempt == 0 ? 0.0 : std::ldexp(kFirstShift, attempt - 1);
    Lower rows = lower;
    std::vector<Mat3> raised = diagonal;
    for (Mat3& block : raised) {
      const double own = std::max(std::abs(trace(block)) / 3.0, 1e-3 * mean);
      block += (shift * own) * kIdentity;
    }
    if (!try_factor(rows, raised, factor.inverse_diagonal)) continue;
    factor.shift = shift;
    factor.offsets = std::move(rows.offsets);
    factor.columns = std::move(rows.columns);
    factor.blocks.resize(rows.blocks.size());
    for (std::size_t k = 0; k < rows.blocks.size(); ++k)
      for (std::size_t i = 0; i < 9; ++i) factor.blocks[k][i] = static_cast<float>(rows.blocks[k].m[i]);
    return factor;
  }
  // Nothing to go by: no preconditioner.
  factor.offsets.assign(diagonal.size() + 1, 0);
  factor.inverse_diagonal.assign(diagonal.size(), kIdentity);
  return factor;
}

void apply_inverse(const BlockCholesky& factor, std::span<const Vec3> b, std::span<Vec3> x) {
  const std::size_t rows = factor.inverse_diagonal.size();
  for (std::size_t v = 0; v < rows; ++v) {
    Vec3 sum = b[v];
    for (std::size_t k = factor.offsets[v]; k < factor.offsets[v + 1]; ++k) {
      const std::array<float, 9>& l = factor.blocks[k];
      const Vec3& y = x[factor.columns[k]];
      sum = sum - Vec3{l[0] * y.x + l[1] * y.y + l[2] * y.z, l[3] * y.x + l[4] * y.y + l[5] * y.z,
                       l[6] * y.x + l[7] * y.y + l[8] * y.z};
    }
    x[v] = sum;
  }
  for (std::size_t v = 0; v < rows; ++v) x[v] = factor.inverse_diagonal[v] * x[v];
  for (std::size_t v = rows; v-- > 0;) {
    const Vec3 y = x[v];
    for (std::size_t k = factor.offsets[v]; k < factor.offsets[v + 1]; ++k) {
      const std::array<float, 9>& l = factor.blocks[k];
      Vec3& target = x[factor.columns[k]];
      target = target - Vec3{l[0] * y.x + l[3] * y.y + l[6] * y.z, l[1] * y.x + l[4] * y.y + l[7] * y.z,
                             l[2] * y.x + l[5] * y.y + l[8] * y.z};
    }
  }
}

}  // namespace palpate::dynamics

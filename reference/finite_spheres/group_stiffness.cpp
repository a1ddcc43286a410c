#include "reference/finite_spheres/group_stiffness.h"

#include <algorithm>

#include "core/base/error.h"

namespace palpate::reference {

using dynamics::BlockMatrix;
using dynamics::Mat3;

BlockMatrix build_sphere_matrix(std::size_t spheres, std::size_t per_sphere,
                                const dynamics::VertexGroups& groups) {
  BlockMatrix coarse = dynamics::build_block_matrix(spheres, {&groups, 1});
  if (per_sphere == 1) return coarse;
  coarse.blocks = {};
  BlockMatrix fine;
  fine.offsets.reserve(per_sphere * spheres + 1);
  fine.columns.reserve(per_sphere * per_sphere * coarse.columns.size());
  for (std::size_t row = 0; row < per_sphere * spheres; ++row) {
    const std::size_t sphere = row / per_sphere;
    for (std::size_t k = coarse.offsets[sphere]; k < coarse.offsets[sphere + 1]; ++k) {
      for (std::size_t n = 0; n < per_sphere; ++n)
        fine.columns.push_back(static_cast<Index>(per_sphere * coarse.columns[k] + n));
    }
    fine.offsets.push_back(fine.columns.size());
  }
  fine.blocks.resize(fine.columns.size());
  return fine;
}

void GroupStiffness::start(std::span<const Index> spheres, std::size_t per_sphere) {
  numbers_.clear();
  for (const Index sphere : spheres) {
    for (std::size_t n = 0; n < per_sphere; ++n)
      numbers_.push_back(static_cast<Index>(per_sphere * sphere + n));
  }
  gradients_.clear();
  weights_.clear();
}

void GroupStiffness::add(std::span<const Index> numbers, std::span<const Vec3> gradients, double weight) {
  const std::size_t start = gradients_.size();
  gradients_.resize(start + 3 * numbers_.size(), 0.0);
  weights_.push_back(weight);
  std::size_t local = 0;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    while (local < numbers_.size() && numbers_[local] < numbers[i]) ++local;
    require(local < numbers_.size() && numbers_[local] == numbers[i], "a function outside its group");
    double* place = gradients_.data() + start + 3 * local;
    place[0] = gradients[i].x;
    place[1] = gradients[i].y;
    place[2] = gradients[i].z;
  }
}

void GroupStiffness::add_to_upper(BlockMatrix& matrix) {
  const std::size_t width = 3 * numbers_.size();
  products_.resize(3 * width);
  for (std::size_t a = 0; a < numbers_.size(); ++a) {
    // Rows 3 a .. 3 a + 2 of the sum of w g g^T, from the diagonal on.
    std::fill(products_.begin(), products_.end(), 0.0);
    for (std::size_t point = 0; point < weights_.size(); ++point) {
      const double* g = gradients_.data() + point * width;
      for (std::size_t i = 0; i < 3; ++i) {
        const double factor = weights_[point] * g[3 * a + i];
        if (factor == 0.0) continue;
        double* row = products_.data() + i * width;
        for (std::size_t k = 3 * a; k < width; ++k) row[k] += factor * g[k];
      }
    }
    std::size_t place = matrix.offsets[numbers_[a]];
    for (std::size_t b = a; b < numbers_.size(); ++b) {
      while (matrix.columns[place] < numbers_[b]) ++place;
      require(matrix.columns[place] == numbers_[b], "a block outside the pattern");
      Mat3 sum;
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) sum(i, j) = products_[i * width + 3 * b + j];
      }
      matrix.blocks[place] +=
          lambda_pa_ * sum + mu_pa_ * (transpose(sum) + dynamics::trace(sum) * dynamics::kIdentity);
    }
  }
}

void add_upper(BlockMatrix& matrix, Index a, Index b, const Mat3& block) {
  if (a <= b) {
    dynamics::add_block(matrix, a, b, block);
  } else {
    dynamics::add_block(matrix, b, a, transpose(block));
  }
}

void mirror_upper(BlockMatrix& matrix) {
  // Rows are visited in order, so the lower entries of each row are met in order too.
  std::vector<std::size_t> next(matrix.offsets.begin(), matrix.offsets.end() - 1);
  for (std::size_t row = 0; row < matrix.rows(); ++row) {
    for (std::size_t k = matrix.offsets[row]; k < matrix.offsets[row + 1]; ++k) {
      const Index column = matrix.columns[k];
      if (column <= row) continue;
      const std::size_t place = next[column]++;
      require(matrix.columns[place] == row, "a pattern that is symmetric");
      matrix.blocks[place] = transpose(matrix.blocks[k]);
    }
  }
}

}  // namespace palpate::reference

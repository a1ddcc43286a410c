#include "core/dynamics/linear_algebra/block_matrix.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/parallel.h"

namespace palpate::dynamics {
namespace {

/// The groups that each vertex is in.
struct Inverse {
  std::vector<std::size_t> offsets;
  std::vector<Index> groups;
};

Inverse invert(std::size_t rows, const VertexGroups& groups) {
  Inverse out{std::vector<std::size_t>(rows + 1, 0), std::vector<Index>(groups.vertices.size())};
  for (const Index v : groups.vertices) ++out.offsets[v + 1];
  for (std::size_t v = 0; v < rows; ++v) out.offsets[v + 1] += out.offsets[v];
  std::vector<std::size_t> next(out.offsets.begin(), out.offsets.end() - 1);
  for (std::size_t g = 0; g + 1 < groups.offsets.size(); ++g) {
    for (Index k = groups.offsets[g]; k < groups.offsets[g + 1]; ++k)
      out.groups[next[groups.vertices[k]]++] = static_cast<Index>(g);
  }
  return out;
}

}  // namespace

BlockMatrix build_block_matrix(std::size_t rows, std::span<const VertexGroups> groups) {
  std::vector<Inverse> inverses;
  inverses.reserve(groups.size());
  for (const VertexGroups& each : groups) inverses.push_back(invert(rows, each));
  BlockMatrix matrix;
  matrix.offsets.reserve(rows + 1);
  std::vector<Index> last_row(rows, kNoIndex);
  std::vector<Index> row;
  for (std::size_t v = 0; v < rows; ++v) {
    row.assign(1, static_cast<Index>(v));
    last_row[v] = static_cast<Index>(v);
    for (std::size_t kind = 0; kind < groups.size(); ++kind) {
      const Inverse& inverse = inverses[kind];
      for (std::size_t g = inverse.offsets[v]; g < inverse.offsets[v + 1]; ++g) {
        const Index group = inverse.groups[g];
        for (Index k = groups[kind].offsets[group]; k < groups[kind].offsets[group + 1]; ++k) {
          const Index other = groups[kind].vertices[k];
          if (last_row[other] == v) continue;
          last_row[other] = static_cast<Index>(v);
          row.push_back(other);
        }
      }
    }
    std::sort(row.begin(), row.end());
    matrix.columns.insert(matrix.columns.end(), row.begin(), row.end());
    matrix.offsets.push_back(matrix.columns.size());
  }
  matrix.blocks.resize(matrix.columns.size());
  return matrix;
}

void add_block(BlockMatrix& matrix, Index row, Index column, const Mat3& block) {
  const auto first = matrix.columns.begin() + static_cast<std::ptrdiff_t>(matrix.offsets[row]);
  const auto last = matrix.columns.begin() + static_cast<std::ptrdiff_t>(matrix.offsets[row + 1]);
  const auto place = std::lower_bound(first, last, column);
  require(place != last && *place == column, "a block outside the pattern");
  matrix.blocks[static_cast<std::size_t>(place - matrix.columns.begin())] += block;
}

void mirror_upper_half(BlockMatrix& matrix) {
  // Rows in order meet the entries below the diagonal of every other row in order.
  std::vector<std::size_t> next(matrix.offsets.begin(), matrix.offsets.end() - 1);
  for (std::size_t v = 0; v < matrix.rows(); ++v) {
    for (std::size_t k = next[v] + 1; k < matrix.offsets[v + 1]; ++k)
      matrix.blocks[next[matrix.columns[k]]++] = transpose(matrix.blocks[k]);
  }
}

void multiply(const BlockMatrix& matrix, std::span<const Vec3> x, std::span<Vec3> y, int threads) {
  require(x.size() == matrix.rows() && y.size() == matrix.rows(), "one entry a row");
  for_ranges(matrix.rows(), threads, [&](std::size_t first, std::size_t last, std::size_t) {
    for (std::size_t v = first; v < last; ++v) {
      Vec3 sum;
      for (std::size_t k = matrix.offsets[v]; k < matrix.offsets[v + 1]; ++k)
        sum = sum + matrix.blocks[k] * x[matrix.columns[k]];
      y[v] = sum;
    }
  });
}

}  // namespace palpate::dynamics

#include "core/dynamics/linear_algebra/laplace_factor.h"

#include <Eigen/SparseCholesky>
#include <string>

#include "core/base/error.h"

namespace palpate::dynamics {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

constexpr std::size_t kLanes = 4;

}  // namespace

LaplaceFactor factor_laplace(std::size_t size, std::span<const ScalarEntry> entries) {
  std::vector<Eigen::Triplet<double>> both;
  both.reserve(entries.size());
  for (const ScalarEntry& entry : entries) {
    require(entry.row < size && entry.column < size, "an entry within the matrix");
    // The lower half is enough.
    const auto [low, high] = std::minmax(entry.row, entry.column);
    both.emplace_back(static_cast<int>(high), static_cast<int>(low), entry.value);
  }
  const auto rows = static_cast<Eigen::Index>(size);
  Sparse matrix(rows, rows);
  matrix.setFromTriplets(both.begin(), both.end());
  const Eigen::SimplicialLLT<Sparse, Eigen::Lower> factor(matrix);
  if (factor.info() != Eigen::Success)
    throw InputError("matrix", 0, "one that is positive definite",
                     std::to_string(size) + " rows that are not");

  LaplaceFactor out;
  const Sparse lower = factor.matrixL();
  out.inverse_diagonal.resize(size);
  for (Eigen::Index j = 0; j < rows; ++j) {
    for (Sparse::InnerIterator entry(lower, j); entry; ++entry) {
      if (entry.row() == j) {
        out.inverse_diagonal[static_cast<std::size_t>(j)] = static_cast<float>(1.0 / entry.value());
      } else {
        out.rows.push_back(static_cast<Index>(entry.row()));
        out.values.push_back(static_cast<float>(entry.value()));
      }
    }
    out.offsets.push_back(out.rows.size());
  }
  out.place.resize(size);
  for (std::size_t v = 0; v < size; ++v)
    out.place[v] = static_cast<Index>(factor.permutationP().indices()[static_cast<Eigen::Index>(v)]);
  return out;
}

void solve(const LaplaceFactor& factor, std::span<const Vec3> b, LaplaceScratch& scratch, std::span<Vec3> x) {
  const std::size_t n = factor.size();
  require(b.size() == n && x.size() == n, "one right side a row");
  scratch.rows.resize(kLanes * n);
  float* const rows = scratch.rows.data();
  for (std::size_t v = 0; v < n; ++v) {
    float* const row = rows + kLanes * factor.place[v];
    row[0] = static_cast<float>(b[v].x);
    row[1] = static_cast<float>(b[v].y);
    row[2] = static_cast<float>(b[v].z);
    row[3] = 0.0F;
  }
  for (std::size_t j = 0; j < n; ++j) {
    float* const own = rows + kLanes * j;
    for (std::size_t lane = 0; lane < kLanes; ++lane) own[lane] *= factor.inverse_diagonal[j];
    for (std::size_t k = factor.offsets[j]; k < factor.offsets[j + 1]; ++k) {
      float* const other = rows + kLanes * factor.rows[k];
      for (std::size_t lane = 0; lane < kLanes; ++lane) other[lane] -= factor.values[k] * own[lane];
    }
  }
  for (std::size_t j = n; j-- > 0;) {
    float* const own = rows + kLanes * j;
    float sum[kLanes] = {own[0], own[1], own[2], own[3]};
    for (std::size_t k = factor.offsets[j]; k < factor.offsets[j + 1]; ++k) {
      const float* const other = rows + kLanes * factor.rows[k];
      for (std::size_t lane = 0; lane < kLanes; ++lane) sum[lane] -= factor.values[k] * other[lane];
    }
    for (std::size_t lane = 0; lane < kLanes; ++lane) own[lane] = sum[lane] * factor.inverse_diagonal[j];
  }
  for (std::size_t v = 0; v < n; ++v) {
    const float* const row = rows + kLanes * factor.place[v];
    x[v] = {row[0], row[1], row[2]};
  }
}

}  // namespace palpate::dynamics

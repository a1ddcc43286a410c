#include "core/springs/training/network_equilibrium.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace palpate::springs {

struct NetworkEquilibrium::State {
  using Matrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;

  const RankOneTerms& terms;
  const TrainingBoundary& boundary;
  std::vector<int> free_number;      // of a component; -1 where held
  Matrix lower;                      // of the free components
  std::vector<std::size_t> slots;    // in `lower`, of each product of two free entries of a term
  std::vector<double> fixed_values;  // of `lower`, from the boundary
  std::vector<double> constant;
  Eigen::SimplicialLDLT<Matrix, Eigen::Lower> factorization;
};

namespace {

using Matrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;

// Calls body(i, j) for the pairs of entries of term q that lie in the lower triangle of the free components.
template <typename Body>
void for_pairs(const RankOneTerms& terms, const std::vector<int>& free_number, std::size_t q, Body&& body) {
  for (std::size_t i = terms.offsets[q]; i < terms.offsets[q + 1]; ++i) {
    const int row = free_number[terms.component[i]];
    if (row < 0) continue;
    for (std::size_t j = terms.offsets[q]; j < terms.offsets[q + 1]; ++j) {
      const int column = free_number[terms.component[j]];
      if (column >= 0 && column <= row) body(i, j);
    }
  }
}

std::size_t slot_of(const Matrix& lower, int row, int column) {
  const int* first = lower.innerIndexPtr() + lower.outerIndexPtr()[column];
  const int* last = lower.innerIndexPtr() + lower.outerIndexPtr()[column + 1];
  return static_cast<std::size_t>(std::lower_bound(first, last, row) - lower.innerIndexPtr());
}

Matrix build_pattern(const RankOneTerms& terms, const TrainingBoundary& boundary,
                     const std::vector<int>& free_number, int free_count) {
  std::vector<Eigen::Triplet<double, int>> entries;
  entries.reserve(static_cast<std::size_t>(free_count) + boundary.stiffness.size());
  for (int i = 0; i < free_count; ++i) entries.emplace_back(i, i, 0.0);
  for (const StiffnessEntry& entry : boundary.stiffness) {
    const int row = free_number[entry.row];
    const int column = free_number[entry.column];
    if (column >= 0 && column <= row) entries.emplace_back(row, column, entry.value_n_per_m);
  }
  for (std::size_t q = 0; q + 1 < terms.offsets.size(); ++q)
    for_pairs(terms, free_number, q, [&](std::size_t i, std::size_t j) {
      entries.emplace_back(free_number[terms.component[i]], free_number[terms.component[j]], 0.0);
    });
  Matrix lower(free_count, free_count);
  lower.setFromTriplets(entries.begin(), entries.end());
  lower.makeCompressed();
  return lower;
}

// image = K u over all components.
std::vector<double> apply_stiffness(const RankOneTerms& terms, const TrainingBoundary& boundary,
                                    std::span<const double> constant, std::span<const double> u) {
  std::vector<double> image(u.size(), 0.0);
  for (std::size_t q = 0; q + 1 < terms.offsets.size(); ++q) {
    double along = 0.0;
    for (std::size_t i = terms.offsets[q]; i < terms.offsets[q + 1]; ++i)
      along += terms.coefficient[i] * u[terms.component[i]];
    for (std::size_t i = terms.offsets[q]; i < terms.offsets[q + 1]; ++i)
      image[terms.component[i]] += constant[q] * along * terms.coefficient[i];
  }
  for (const StiffnessEntry& entry : boundary.stiffness)
    image[entry.row] += entry.value_n_per_m * u[entry.column];
  return image;
}

}  // namespace

NetworkEquilibrium::NetworkEquilibrium(const RankOneTerms& terms, const TrainingBoundary& boundary)
    : state_(new State{terms, boundary, {}, {}, {}, {}, {}, {}}) {
  State& state = *state_;
  int free_count = 0;
  for (const std::uint8_t held : boundary.held) state.free_number.push_back(held != 0 ? -1 : free_count++);
  state.lower = build_pattern(terms, boundary, state.free_number, free_count);
  state.fixed_values.assign(state.lower.valuePtr(), state.lower.valuePtr() + state.lower.nonZeros());
  for (std::size_t q = 0; q + 1 < terms.offsets.size(); ++q)
    for_pairs(terms, state.free_number, q, [&](std::size_t i, std::size_t j) {
      state.slots.push_back(
          slot_of(state.lower, state.free_number[terms.component[i]], state.free_number[terms.component[j]]));
    });
  state.factorization.analyzePattern(state.lower);
}

NetworkEquilibrium::~NetworkEquilibrium() = default;
NetworkEquilibrium::NetworkEquilibrium(NetworkEquilibrium&&) noexcept = default;
NetworkEquilibrium& NetworkEquilibrium::operator=(NetworkEquilibrium&&) noexcept = default;

bool NetworkEquilibrium::factor(std::span<const double> constant) {
  State& state = *state_;
  const RankOneTerms& terms = state.terms;
  state.constant.assign(constant.begin(), constant.end());
  double* values = state.lower.valuePtr();
  std::copy(state.fixed_values.begin(), state.fixed_values.end(), values);
  std::size_t at = 0;
  for (std::size_t q = 0; q + 1 < terms.offsets.size(); ++q)
    for_pairs(terms, state.free_number, q, [&](std::size_t i, std::size_t j) {
      values[state.slots[at++]] += constant[q] * terms.coefficient[i] * terms.coefficient[j];
    });
  state.factorization.factorize(state.lower);
  if (state.factorization.info() != Eigen::Success) return false;
  // A pivot that is nothing but the rounding of the stiffness it came from is a motion without resistance.
  const Eigen::VectorXd pivots = state.factorization.vectorD();
  const double largest = state.lower.diagonal().cwiseAbs().maxCoeff();
  return pivots.size() == 0 || (pivots.allFinite() && pivots.minCoeff() > 1e-13 * largest);
}

std::vector<double> NetworkEquilibrium::solve_adjoint(std::span<const double> rhs) const {
  const State& state = *state_;
  Eigen::VectorXd right(state.lower.rows());
  for (std::size_t i = 0; i < rhs.size(); ++i)
    if (state.free_number[i] >= 0) right[state.free_number[i]] = rhs[i];
  const Eigen::VectorXd solution = state.factorization.solve(right);
  std::vector<double> x(rhs.size(), 0.0);
  for (std::size_t i = 0; i < x.size(); ++i)
    if (state.free_number[i] >= 0) x[i] = solution[state.free_number[i]];
  return x;
}

std::vector<double> NetworkEquilibrium::solve(std::span<const double> force_n,
                                              std::span<const double> held_m) const {
  const State& state = *state_;
  std::vector<double> u(force_n.size(), 0.0);
  for (std::size_t i = 0; i < u.size(); ++i)
    if (state.free_number[i] < 0) u[i] = held_m[i];
  std::vector<double> residual = apply_stiffness(state.terms, state.boundary, state.constant, u);
  for (std::size_t i = 0; i < u.size(); ++i) residual[i] = force_n[i] - residual[i];
  const std::vector<double> step = solve_adjoint(residual);
  for (std::size_t i = 0; i < u.size(); ++i) u[i] += step[i];
  return u;
}

}  // namespace palpate::springs

// What one answer of a linear model costs, in units that hold for all of them.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>

#include "core/base/stopwatch.h"
#include "core/dynamics/linear_algebra/block_matrix.h"
#include "core/dynamics/linear_algebra/sparse_factor.h"

namespace palpate::reference {

/// Calls that a median is taken of.
inline constexpr std::size_t kTimedCalls = 51;

/// The median time of one call, in s.
template <typename Work>
double median_seconds(const Work& work) {
  std::array<double, kTimedCalls> times{};
  for (double& time : times) {
    const Stopwatch start;
    work();
    time = start.seconds();
  }
  std::nth_element(times.begin(), times.begin() + kTimedCalls / 2, times.end());
  return times[kTimedCalls / 2];
}

/// Cost of an answer. All times are medians on one thread, taken outside of the kernel.
struct AnswerCost {
  std::size_t unknowns = 0;
  std::size_t stiffness_entries = 0;  ///< numbers of the matrix, both halves: multiplications of a product
  std::size_t factor_entries = 0;     ///< numbers that a back-substitution reads twice
  double product_s = 0.0;             ///< a product with the matrix
  double answer_s = 0.0;              ///< a displacement from a new load, with all that is prepared
};

/// Measures matrix and factor of a system: a product, and a back-substitution.
AnswerCost measure_cost(const dynamics::BlockMatrix& matrix, const dynamics::SymmetricFactor& factor,
                        std::size_t unknowns);

/// The same with the factorisation made here (choose_factor's "auto"); `held` as number_free takes it.
AnswerCost measure_cost(const dynamics::BlockMatrix& matrix, std::span<const std::uint8_t> held);

/// Adds the figures by their names.
void report_cost(const AnswerCost& cost, nlohmann::json& report);

}  // namespace palpate::reference

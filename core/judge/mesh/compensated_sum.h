// Sums whose rounding does not grow with their length.
#pragma once

#include <cmath>

namespace palpate::judge {

/// Neumaier's compensated sum: the error is about one rounding of the result plus n^2 2^-106 of the sum of
/// the magnitudes. Source: Neumaier, ZAMM 54 (1974).
class CompensatedSum {
 public:
  void add(double value) {
    const double sum = sum_ + value;
    correction_ += std::fabs(sum_) >= std::fabs(value) ? (sum_ - sum) + value : (value - sum) + sum_;
    sum_ = sum;
  }

  double value() const { return sum_ + correction_; }

 private:
  double sum_ = 0.0;
  double correction_ = 0.0;
};

}  // namespace palpate::judge

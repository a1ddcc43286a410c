// Signals in closed form, for the tests of histories and oscillations.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

namespace palpate::test {

/// 0, end / intervals, ... end.
inline std::vector<double> times(double end, int intervals) {
  std::vector<double> out;
  for (int k = 0; k <= intervals; ++k) out.push_back(end * k / intervals);
  return out;
}

/// f at each of the times.
inline std::vector<double> values(const std::vector<double>& at, const std::function<double(double)>& f) {
  std::vector<double> out(at.size());
  std::transform(at.begin(), at.end(), out.begin(), f);
  return out;
}

/// 0.3 + 2 exp(-decay t) cos(2 pi hz t + 0.4).
inline std::function<double(double)> ringing(double hz, double decay) {
  return [=](double t) {
    return 0.3 + 2.0 * std::exp(-decay * t) * std::cos(2.0 * std::numbers::pi * hz * t + 0.4);
  };
}

}  // namespace palpate::test

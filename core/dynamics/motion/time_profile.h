// How much of a load or a prescribed motion there is at each time.
#pragma once

#include <vector>

namespace palpate::dynamics {

/// A share of a load, a function of time: between the given times it runs straight (`smooth` false) or along
/// the quintic 6 s^5 - 15 s^4 + 10 s^3, which starts and ends without speed and acceleration. Before the
/// first time it has the first share, after the last one the last.
///
/// Shape:  as many times as shares, at least one; times increase.
struct TimeProfile {
  std::vector<double> time_s{0.0};
  std::vector<double> share{1.0};
  bool smooth = false;
};

/// A profile and its two derivatives at one time. At a kink they are those of what follows.
struct ProfileValue {
  double share = 0.0;
  double rate_per_s = 0.0;
  double acceleration_per_s2 = 0.0;
};

/// The profile at time_s. Logarithmic in the number of times.
ProfileValue value_at(const TimeProfile& profile, double time_s);

/// Throws: InputError unless times and shares are finite, as many, at least one, and the times increase.
void validate(const TimeProfile& profile);

}  // namespace palpate::dynamics

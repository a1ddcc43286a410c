#include "core/dynamics/motion/time_profile.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/error.h"

namespace palpate::dynamics {

ProfileValue value_at(const TimeProfile& profile, double time_s) {
  const auto after = std::upper_bound(profile.time_s.begin(), profile.time_s.end(), time_s);
  if (after == profile.time_s.begin()) return {profile.share.front(), 0.0, 0.0};
  if (after == profile.time_s.end()) return {profile.share.back(), 0.0, 0.0};
  const auto k = static_cast<std::size_t>(after - profile.time_s.begin());
  const double width = profile.time_s[k] - profile.time_s[k - 1];
  const double rise = profile.share[k] - profile.share[k - 1];
  const double s = (time_s - profile.time_s[k - 1]) / width;
  if (!profile.smooth) return {profile.share[k - 1] + s * rise, rise / width, 0.0};
  const double left = 1.0 - s;
  return {profile.share[k - 1] + s * s * s * (10.0 + s * (6.0 * s - 15.0)) * rise,
          30.0 * s * s * left * left * rise / width,
          60.0 * s * left * (1.0 - 2.0 * s) * rise / (width * width)};
}

void validate(const TimeProfile& profile) {
  if (profile.time_s.empty() || profile.time_s.size() != profile.share.size())
    throw InputError("profile", 0, "as many times as shares, at least one",
                     std::to_string(profile.time_s.size()) + " times and " +
                         std::to_string(profile.share.size()) + " shares");
  for (std::size_t k = 0; k < profile.time_s.size(); ++k) {
    if (!std::isfinite(profile.time_s[k]) || !std::isfinite(profile.share[k]))
      throw InputError("profile", 0, "finite times and shares", "one that is not");
    if (k > 0 && !(profile.time_s[k] > profile.time_s[k - 1]))
      throw InputError("profile", 0, "times that increase", std::to_string(profile.time_s[k]));
  }
}

}  // namespace palpate::dynamics

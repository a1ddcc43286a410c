// Angles of closed forms.
#pragma once

#include <numbers>

namespace palpate::test {

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kDegree = kPi / 180.0;  ///< in radians

}  // namespace palpate::test

// The components of a vector by the number of their axis.
#pragma once

#include <cstddef>

#include "core/base/types.h"

namespace palpate {

/// The component of a vector along an axis: 0, 1 or 2.
constexpr double component(const Vec3& v, std::size_t axis) {
  return axis == 0 ? v.x : (axis == 1 ? v.y : v.z);
}
/// The same, to be changed.
constexpr double& component(Vec3& v, std::size_t axis) {
  return axis == 0 ? v.x : (axis == 1 ? v.y : v.z);
}

}  // namespace palpate

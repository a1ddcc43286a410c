// A coordinate by the number of its axis.
#pragma once

#include <cstddef>

#include "core/base/types.h"

namespace palpate::springs {

/// x, y or z of a point for axis 0, 1 or 2.
constexpr double along_axis(const Vec3& p, std::size_t axis) {
  return axis == 0 ? p.x : (axis == 1 ? p.y : p.z);
}

}  // namespace palpate::springs

// Points in an order that keeps neighbours in space near each other in memory.
#pragma once

#include <span>
#include <vector>

#include "core/base/types.h"

namespace palpate {

/// The numbers of the points along the Morton curve through their bounding box, at 2^21 cells a side; points
/// of one cell by number. Any number of threads gives the same.
std::vector<Index> order_in_space(std::span<const Vec3> points, int threads = 1);

}  // namespace palpate

// Faces cut at the planes between the cells of a grid, so that each part lies in one cell.
#pragma once

#include <array>
#include <vector>

#include "core/base/types.h"

namespace palpate::springs {

/// The parts of a triangle between the planes x = i, y = j, z = k, as triangles with its direction. `corners`
/// counted in cells. Without the parts that have no area.
std::vector<std::array<Vec3, 3>> split_at_cells(const std::array<Vec3, 3>& corners);

}  // namespace palpate::springs

// Regions to keep as one line of text: on the command line, in plans, requests and records alike.
#pragma once

#include <string>
#include <vector>

#include "core/simplify/sizing/sizing.h"

namespace palpate::simplify {

/// The words that a region starts with: sphere, half_space, patch.
const std::vector<std::string>& kept_region_kinds();

/// Reads a region; lengths in the mesh's own coordinates.
///
///   sphere x y z r            the ball of radius r around (x, y, z)
///   half_space nx ny nz o     n . x <= o; n points out of what is kept, and has any length but 0
///   patch x y z r d           within d of the boundary faces that have a vertex in that ball
///
/// Throws: InputError "where: ..." for another word, another number of numbers, or a number out of range.
KeptRegion parse_kept_region(const std::string& text, const std::string& where);

}  // namespace palpate::simplify

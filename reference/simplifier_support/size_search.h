// A remesher takes an edge length, a contest asks for a number of tets: the search for the one that gives the
// other.
#pragma once

#include <cstdint>
#include <functional>

#include "reference/simplifier_support/isolated_run.h"

namespace palpate::reference {

/// Makes a mesh with edges of about `size`. Throws std::runtime_error where it cannot.
using SizedMesher = std::function<TimedMesh(double size)>;

/// The try whose count came nearest to the target.
struct FoundSize {
  double size = 0.0;
  TimedMesh result;  ///< that try's mesh and time
  int tries = 0;
};

/// (tets - target) / target.
double count_mismatch(std::uint64_t tets, std::uint64_t target);

/// Searches for the size at which `mesher` leaves `target` tets.
///
/// The count falls about as size^-3: from `first_size` on, each next size follows from that, later from the
/// secant of the logarithms, between the sizes that enclose the target by bisection where the count jumps;
/// where they close in on a jump, a few sizes beside it.
/// Ends within 0.2%, after eight tries within 0.5%, else after twenty tries, or when a size twice as
/// large leaves as many tets; the nearest try is returned. A size at which `mesher` throws is left by 1%.
/// Throws: what `mesher` threw, if it did three times in a row.
FoundSize search_size(const SizedMesher& mesher, double first_size, std::uint64_t target);

}  // namespace palpate::reference

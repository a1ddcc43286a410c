// The unit of length of a mesh without one, from the size of human organs.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace palpate::experiments {

/// The unit that a mesh most likely has.
struct UnitGuess {
  double unit_m = 0.0;
  std::vector<double> others;  ///< that would make an organ of it too
};

inline constexpr double kSmallestOrganM = 0.01;  ///< across the diagonal of its box
inline constexpr double kLargestOrganM = 0.6;

/// Guesses by the diagonal of the mesh's box: of 0.001, 0.01 and 1 m, those are candidates with which it
/// becomes 1 to 60 cm. Of several, the first that makes it the usual 4 to 40 cm is taken, else the first.
/// Nothing if there are none.
std::optional<UnitGuess> guess_unit(double diagonal);

/// "mm", "cm" or "m"; else the number with "m" behind.
std::string unit_name(double unit_m);

}  // namespace palpate::experiments

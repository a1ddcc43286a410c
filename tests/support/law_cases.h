// Laws of strain energy and the matrices that they are held against.
#pragma once

#include <array>
#include <cmath>

#include "core/base/random.h"
#include "core/dynamics/elasticity/elastic_law.h"

namespace palpate::testing_support {

inline constexpr std::array kLaws{dynamics::StrainLaw::kLinear, dynamics::StrainLaw::kCorotated,
                                  dynamics::StrainLaw::kNeoHookean, dynamics::StrainLaw::kStableNeoHookean};
inline constexpr dynamics::Moduli kModuli{3.0, 2.0};

/// Entries from -size to size.
inline dynamics::Mat3 random_matrix(SplitMix64& random, double size) {
  dynamics::Mat3 h;
  for (double& entry : h.m) entry = size * (2.0 * random.uniform() - 1.0);
  return h;
}

/// The root of the sum of the squares.
inline double norm(const dynamics::Mat3& a) {
  return std::sqrt(contract(a, a));
}

}  // namespace palpate::testing_support

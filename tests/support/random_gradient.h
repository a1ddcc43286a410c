// Gradients of small displacements, at random.
#pragma once

#include <cstdint>

#include "core/base/random.h"
#include "core/dynamics/linear_algebra/matrix3.h"

namespace palpate::testing_support {

/// Nine entries of up to 0.01.
inline dynamics::Mat3 make_gradient(std::uint64_t seed) {
  SplitMix64 random(seed);
  dynamics::Mat3 gradient;
  for (double& entry : gradient.m) entry = 0.02 * (random.uniform() - 0.5);
  return gradient;
}

}  // namespace palpate::testing_support

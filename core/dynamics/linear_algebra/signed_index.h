// Sizes as Eigen counts them.
#pragma once

#include <cstddef>

namespace palpate::dynamics {

/// A size or place as a signed number (Eigen::Index).
constexpr std::ptrdiff_t signed_index(std::size_t number) {
  return static_cast<std::ptrdiff_t>(number);
}

}  // namespace palpate::dynamics

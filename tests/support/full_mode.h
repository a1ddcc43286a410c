// What takes long is done whole in the full mode of the tests (`palpate test --full`), and in part at each
// change.
#pragma once

#include <cstdlib>

namespace palpate::test {

/// Whether the tests run in the full mode.
inline bool is_full() {
  const char* mode = std::getenv("PALPATE_FULL");
  return mode != nullptr && *mode != '\0';
}

/// `full` in the full mode, else `quick`.
inline int full_or(int full, int quick) {
  return is_full() ? full : quick;
}

}  // namespace palpate::test

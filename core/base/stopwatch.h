// How long something takes.
#pragma once

#include <chrono>

namespace palpate {

/// Measures from its making on, by a clock that never goes back.
class Stopwatch {
 public:
  /// Seconds since the making.
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace palpate

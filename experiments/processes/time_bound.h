// A time limit for who waits.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace palpate::experiments {

/// Runs from its making on, and leaves out what this program was stopped for (SIGSTOP, Ctrl-Z): a wait that
/// took seconds longer than it was to has seen that, and so much later the time is up.
///
///     for (TimeBound bound(60.0); !bound.is_up(); bound.look()) wait_at_most(bound.wait_ms(100));
class TimeBound {
 public:
  explicit TimeBound(double seconds) : end_(last_look_ + as_duration(seconds)) {}

  /// How long the next wait may take, in milliseconds: to the end of the time, and no longer than `most`.
  int wait_ms(std::int64_t most) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end_ - Clock::now());
    const std::int64_t milliseconds = std::clamp<std::int64_t>(left.count(), 0, most);
    wait_ = std::chrono::milliseconds(milliseconds);
    return static_cast<int>(milliseconds);
  }

  /// After each wait. Returns whether this program was stopped meanwhile.
  bool look() {
    constexpr auto kMostLate = std::chrono::seconds(2);  // on a busy machine
    const Clock::time_point now = Clock::now();
    const Clock::duration late = now - last_look_ - wait_;
    last_look_ = now;
    if (late <= kMostLate) return false;
    end_ += late;
    stopped_ += late;
    return true;
  }

  /// As of the last look.
  bool is_up() const { return last_look_ >= end_; }
  double stopped_s() const { return std::chrono::duration<double>(stopped_).count(); }

 private:
  using Clock = std::chrono::steady_clock;

  static Clock::duration as_duration(double seconds) {
    return std::chrono::duration_cast<Clock::duration>(
        std::chrono::duration<double>(std::clamp(seconds, 0.0, 1e8)));
  }

  Clock::time_point last_look_ = Clock::now();
  Clock::time_point end_;
  Clock::duration wait_{};
  Clock::duration stopped_{};
};

}  // namespace palpate::experiments

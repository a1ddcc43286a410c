// What the repeats that are left will take, kept while they are run.
#pragma once

#include <algorithm>
#include <cstddef>

namespace palpate::experiments {

/// The time for the repeats that are left, at most: a case may end before it has the most. One step costs the
/// same in a run of ten cases and of a million.
class RestTime {
 public:
  /// Counts a case's due repeats in; `wall_s` is what one took, below zero where none was run.
  void add(int due, double wall_s) { count(due, wall_s, 1.0); }
  /// Takes back what was counted so.
  void remove(int due, double wall_s) { count(due, wall_s, -1.0); }

  std::size_t repeats() const { return static_cast<std::size_t>(known_due_ + unknown_due_); }
  /// A case of which none was run is taken to be as long as the others' mean; where no case's time is known,
  /// as in a run without times, as `typical_s`.
  double seconds(double typical_s) const {
    const double unknown_s = cases_ > 0.0 ? wall_s_ / cases_ : typical_s;
    return std::max(0.0, known_s_ + unknown_due_ * unknown_s);
  }

 private:
  void count(double due, double wall_s, double sign) {
    if (wall_s < 0.0) {
      unknown_due_ += sign * due;
      return;
    }
    known_due_ += sign * due;
    known_s_ += sign * due * wall_s;
    wall_s_ += sign * wall_s;
    cases_ += sign;
  }

  double known_due_ = 0.0;    ///< repeats of cases of which one was run
  double unknown_due_ = 0.0;  ///< of the others
  double known_s_ = 0.0;      ///< what the known ones take
  double wall_s_ = 0.0;       ///< one repeat of each known case
  double cases_ = 0.0;        ///< known cases
};

}  // namespace palpate::experiments

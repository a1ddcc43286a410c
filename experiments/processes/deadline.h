// A time limit as a stop flag.
#pragma once

#include <atomic>
#include <csignal>
#include <thread>

#include "experiments/processes/time_bound.h"

namespace palpate::experiments {

/// Turns a flag when the time is up, or when the user's own turns. What the program was stopped for is no
/// time.
class Deadline {
 public:
  /// `user` may be null; it has to live as long as this.
  Deadline(double seconds, const volatile std::sig_atomic_t* user);
  ~Deadline();
  Deadline(const Deadline&) = delete;
  Deadline& operator=(const Deadline&) = delete;

  const volatile std::sig_atomic_t* flag() const { return &flag_; }

 private:
  void watch();

  const volatile std::sig_atomic_t* user_;
  TimeBound bound_;
  volatile std::sig_atomic_t flag_ = 0;
  std::atomic<bool> is_over_ = false;
  std::thread watcher_;
};

}  // namespace palpate::experiments

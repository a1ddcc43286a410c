// A time limit as a stop flag.
#pragma once

#include <atomic>
#include <chrono>
#include <csignal>
#include <thread>

namespace palpate::experiments {

/// Turns a flag when the time is up, or when the user's own turns.
class Deadline {
 public:
  /// `user` may be null; it has to live as long as this.
  Deadline(double seconds, const volatile std::sig_atomic_t* user);
  ~Deadline();
  Deadline(const Deadline&) = delete;
  Deadline& operator=(const Deadline&) = delete;

  const volatile std::sig_atomic_t* flag() const { return &flag_; }

 private:
  using Clock = std::chrono::steady_clock;

  void watch();

  const volatile std::sig_atomic_t* user_;
  Clock::time_point end_;
  volatile std::sig_atomic_t flag_ = 0;
  std::atomic<bool> is_over_ = false;
  std::thread watcher_;
};

}  // namespace palpate::experiments

// Threads that end with their owner, and the place where they wait for each other; on a platform without
// threads, such as WebAssembly in a page, the caller's own alone.
#pragma once

#ifdef __EMSCRIPTEN__

#include <cstddef>
#include <utility>

namespace palpate {

inline constexpr bool kHasThreads = false;

/// Does its work at once, on the caller's thread.
class Thread {
 public:
  template <typename Work, typename... All>
  explicit Thread(Work&& work, All&&... all) {
    std::forward<Work>(work)(std::forward<All>(all)...);
  }
};

/// Where one thread meets itself: nobody is waited for.
template <typename Then>
class Meeting {
 public:
  Meeting(std::ptrdiff_t, Then then) : then_(std::move(then)) {}
  void arrive_and_wait() { then_(); }

 private:
  Then then_;
};

/// Nobody waits at it.
class StartGate {
 public:
  void open(bool) {}
  bool may_start() { return true; }
};

}  // namespace palpate

#else

#include <atomic>
#include <barrier>
#include <thread>

namespace palpate {

/// Whether there is more than the caller's thread.
inline constexpr bool kHasThreads = true;

/// Joined where it ends.
using Thread = std::jthread;

/// Where as many threads as were said wait for each other; the last one then does `Then`, which must not
/// throw.
template <typename Then>
using Meeting = std::barrier<Then>;

/// Where threads wait until all of them are there, or until it is known that they will not be.
class StartGate {
 public:
  void open(bool go) {
    state_ = go ? kGo : kGiveUp;
    state_.notify_all();
  }
  /// Waits for open(); returns what it was given.
  bool may_start() {
    state_.wait(kClosed);
    return state_ == kGo;
  }

 private:
  enum State : int { kClosed, kGo, kGiveUp };
  std::atomic<State> state_ = kClosed;
};

}  // namespace palpate

#endif

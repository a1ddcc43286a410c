#include "experiments/processes/deadline.h"

#include <algorithm>

namespace palpate::experiments {

Deadline::Deadline(double seconds, const volatile std::sig_atomic_t* user)
    : user_(user),
      end_(Clock::now() + std::chrono::duration_cast<Clock::duration>(
                              std::chrono::duration<double>(std::max(0.0, seconds)))),
      watcher_([this] { watch(); }) {}

Deadline::~Deadline() {
  is_over_ = true;
  watcher_.join();
}

void Deadline::watch() {
  while (!is_over_ && flag_ == 0) {
    if (Clock::now() >= end_ || (user_ != nullptr && *user_ != 0)) flag_ = 1;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

}  // namespace palpate::experiments

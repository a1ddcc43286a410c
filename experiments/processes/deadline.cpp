#include "experiments/processes/deadline.h"

#include <chrono>

namespace palpate::experiments {

Deadline::Deadline(double seconds, const volatile std::sig_atomic_t* user)
    : user_(user), bound_(seconds), watcher_([this] { watch(); }) {}

Deadline::~Deadline() {
  is_over_ = true;
  watcher_.join();
}

void Deadline::watch() {
  constexpr int kPeriodMs = 20;
  for (; !is_over_ && flag_ == 0; bound_.look()) {
    if (bound_.is_up() || (user_ != nullptr && *user_ != 0)) flag_ = 1;
    std::this_thread::sleep_for(std::chrono::milliseconds(bound_.wait_ms(kPeriodMs)));
  }
}

}  // namespace palpate::experiments

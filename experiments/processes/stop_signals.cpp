#include "experiments/processes/stop_signals.h"

namespace palpate::experiments {
namespace {

volatile std::sig_atomic_t g_stop = 0;

}  // namespace

const volatile std::sig_atomic_t* catch_stop_signals() {
  struct sigaction action {};
  action.sa_handler = [](int) { g_stop = 1; };
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
  return &g_stop;
}

}  // namespace palpate::experiments

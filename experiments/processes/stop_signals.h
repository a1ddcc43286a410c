// Ctrl-C and kill as a flag, for work that is to be ended in order.
#pragma once

#include <csignal>

namespace palpate::experiments {

/// From now on SIGINT and SIGTERM turn the flag non-zero instead of ending the program. Returns the flag,
/// which lives as long as the program.
const volatile std::sig_atomic_t* catch_stop_signals();

}  // namespace palpate::experiments

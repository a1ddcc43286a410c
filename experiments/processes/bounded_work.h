// Work in a child process that has bounds of time and memory: what judges an answer must not end the run.
#pragma once

#include <csignal>
#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

namespace palpate::experiments {

/// Bounds of work in a child.
struct WorkBounds {
  double timeout_s = 600.0;                               ///< wall clock
  std::uint64_t memory_bytes = std::uint64_t{8} << 30U;   ///< beyond what this process has; 0: no bound
  const volatile std::sig_atomic_t* stop_flag = nullptr;  ///< the work is given up when it turns non-zero
};

/// How it went.
enum class WorkEnd { kDone, kTimedOut, kOutOfMemory, kCrashed, kInterrupted };

struct WorkResult {
  WorkEnd end = WorkEnd::kCrashed;
  nlohmann::json value;  ///< what the work returned; only for kDone
  std::string message;   ///< one line for a person, empty for kDone: "took longer than 600 s"
};

/// Runs `work` in a forked child, which starts with a copy of this process's memory and is killed with it,
/// and brings its value back through a pipe. Nothing that the work changes is seen here.
/// Requires: no other thread of this process holds a lock that `work` takes (a Deadline's takes none).
/// Throws: InputError and UnavailableError if `work` threw one, with its message; ContractError for any other
/// exception of it; UnavailableError if no child can be started.
WorkResult run_bounded(const std::function<nlohmann::json()>& work, const WorkBounds& bounds);

}  // namespace palpate::experiments

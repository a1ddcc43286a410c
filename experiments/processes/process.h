// Child processes with a time-out, a memory bound and their own peak memory.
#pragma once

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace palpate::experiments {

/// What to start, and its bounds. Nothing goes through a shell.
struct ProcessSpec {
  std::vector<std::string> arguments;  ///< program path first
  double timeout_s = 300.0;            ///< wall clock; all that came of it is killed after it
  /// Bound of each process's address space, and of the resident memory of all of them together (looked at ten
  /// times a second); 0 for none (and in sanitizer builds).
  std::uint64_t memory_bytes = 0;
  std::uint64_t file_bytes = 0;           ///< the largest file that they may write; 0: no bound
  std::filesystem::path standard_output;  ///< file that receives it; empty: discarded
  std::filesystem::path standard_error;   ///< file that receives it, of a flood its end; empty: discarded
  int threads = 1;                        ///< what the child sees as OMP_NUM_THREADS
  const volatile std::sig_atomic_t* stop_flag = nullptr;  ///< all is killed when it turns non-zero ...
  double stop_grace_s =
      0.0;  ///< ... or its group is sent SIGINT, and all killed if it has not ended so long after
  std::function<void()> while_waiting;  ///< called some ten times a second until it ends; may be empty
};

/// How a child ended.
enum class ProcessEnd { kExited, kSignalled, kTimedOut, kInterrupted, kNotStarted, kTooMuchMemory };

struct ProcessResult {
  ProcessEnd end = ProcessEnd::kNotStarted;
  int exit_code = -1;  ///< valid for kExited
  int signal = 0;      ///< valid for kSignalled
  double wall_s = 0.0;
  double stopped_s = 0.0;  ///< of it this program was stopped itself (Ctrl-Z, a suspended job), to a second
  bool has_usage = false;  ///< whether the three figures below are known: not if it was timed out or stopped
  double user_s = 0.0;
  double system_s = 0.0;
  /// Of the largest process that came of it; of those that were seen at one time together, if that is more.
  std::uint64_t peak_rss_bytes = 0;
  std::string message;  ///< one line for a person: "timed out after 300 s", "killed by signal 11"
};

/// Runs a child to its end, and to that of all that it started: what is left of them then, be it in a session
/// of its own, is killed. So it is when this process dies (also by kill -9). The child has no standard input,
/// and sees the environment with LC_ALL=C and OMP_NUM_THREADS as asked for.
ProcessResult run_process(const ProcessSpec& spec);

}  // namespace palpate::experiments

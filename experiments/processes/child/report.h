// What palpate_child tells the process that started it, and is told by it.
#pragma once

#include <sys/resource.h>

#include <cstdint>

namespace palpate::experiments {

/// The file descriptor that the reports are written to.
inline constexpr int kChildReportFile = 3;

/// The file descriptor that orders are read from. Its end, which a killed starter leaves too, is kKillAll.
inline constexpr int kChildOrderFile = 4;

/// Orders, one byte each.
enum ChildOrder : char {
  kInterrupt = 'i',  ///< SIGINT to the program's group
  kKillAll = 'k'     ///< the program and all that came of it are killed
};

/// How long palpate_child goes on killing where nothing changes, and where new processes come all the time.
inline constexpr int kPatienceS = 16;
inline constexpr int kPatienceWithStormsS = 60;

/// One report: the program could not be started (`value` is the error number), or it ended (`value` is the
/// status of wait4), or it was killed because it and what it started took more memory than it may. `usage`
/// and `peak_bytes` are those of the whole tree.
struct ChildReport {
  enum Kind : int { kNotStarted = 1, kEnded = 2, kTooMuchMemory = 3 };

  int kind = 0;
  int value = 0;
  rusage usage{};
  std::uint64_t peak_bytes = 0;  ///< largest resident memory of one process, or of several at a time if seen
  std::uint64_t left = 0;        ///< processes that could not be ended
};

}  // namespace palpate::experiments

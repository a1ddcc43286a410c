// What palpate_child tells the process that started it.
#pragma once

#include <sys/resource.h>

namespace palpate::experiments {

/// The file descriptor that the reports are written to.
inline constexpr int kChildReportFile = 3;

/// One report: the program could not be started (`value` is the error number), or it ended (`value` is the
/// status of wait4, `usage` its own resource usage).
struct ChildReport {
  enum Kind : int { kNotStarted = 1, kEnded = 2 };

  int kind = 0;
  int value = 0;
  rusage usage{};
};

}  // namespace palpate::experiments

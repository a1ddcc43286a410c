// palpate_child PROGRAM ARGUMENT...: starts a program, waits for it, and reports its end and resource usage.
//
// Linux counts the memory of the process that forks to the peak of the child that it execs. Started from this
// small program, a contestant's peak is its own, however large the runner has grown.
#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>

#include "experiments/processes/child/report.h"

namespace {

using palpate::experiments::ChildReport;
using palpate::experiments::kChildReportFile;

bool send(const ChildReport& report) {
  return ::write(kChildReportFile, &report, sizeof report) == sizeof report;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return 126;
  ::fcntl(kChildReportFile, F_SETFD, FD_CLOEXEC);
  const pid_t self = ::getpid();
  const pid_t child = ::fork();
  ChildReport report;
  if (child == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != self) ::_exit(127);
    ::execv(argv[1], argv + 1);
    report.kind = ChildReport::kNotStarted;
    report.value = errno;
    send(report);
    ::_exit(127);
  }
  if (child < 0) {
    report.kind = ChildReport::kNotStarted;
    report.value = errno;
    return send(report) ? 127 : 126;
  }
  ::signal(SIGINT, SIG_IGN);  // a program that is asked to end in order is waited for
  while (::wait4(child, &report.value, 0, &report.usage) < 0 && errno == EINTR) {
  }
  report.kind = ChildReport::kEnded;
  return send(report) ? 0 : 126;
}

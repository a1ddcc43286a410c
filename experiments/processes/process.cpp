#include "experiments/processes/process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <optional>
#include <string>

#include "core/base/error.h"
#include "experiments/files/places.h"
#include "experiments/processes/child/report.h"

namespace palpate::experiments {
namespace {

double seconds_of(const timeval& t) {
  return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
}

void redirect(int target, const std::filesystem::path& path) {
  const char* name = path.empty() ? "/dev/null" : path.c_str();
  const int file = ::open(name, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (file >= 0) ::dup2(file, target);
}

/// Runs in the child between fork and exec: only calls that are safe there.
[[noreturn]] void become(const ProcessSpec& spec, const std::vector<char*>& arguments, pid_t parent,
                         int report_pipe) {
  ::setpgid(0, 0);
  ::signal(SIGPIPE, SIG_DFL);  // this program ignores it, and exec would hand that on
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(127);  // the parent died before the line above
  const int null = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (null >= 0) ::dup2(null, STDIN_FILENO);
  redirect(STDOUT_FILENO, spec.standard_output);
  redirect(STDERR_FILENO, spec.standard_error);
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
#ifndef PALPATE_SANITIZED
  if (spec.memory_bytes > 0) {
    const rlimit bound{spec.memory_bytes, spec.memory_bytes};
    ::setrlimit(RLIMIT_AS, &bound);
  }
#endif
  if (report_pipe == kChildReportFile) {
    ::fcntl(report_pipe, F_SETFD, 0);
  } else {
    ::dup2(report_pipe, kChildReportFile);
  }
  ::execv(arguments[0], arguments.data());
  ChildReport report;
  report.kind = ChildReport::kNotStarted;
  report.value = errno;
  const ssize_t written = ::write(kChildReportFile, &report, sizeof report);
  ::_exit(written == sizeof report ? 127 : 126);
}

enum class Wait { kEnded, kTimeUp, kStopped };

/// Waits until the child ends, the time is up or the stop flag rises.
Wait wait_for_end(pid_t child, std::chrono::steady_clock::time_point deadline,
                  const volatile std::sig_atomic_t* stop_flag, const std::function<void()>& meanwhile) {
  constexpr std::int64_t kFlagPeriodMs = 100;
  const int handle = static_cast<int>(::syscall(SYS_pidfd_open, child, 0));
  while (true) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
    const std::int64_t longest = stop_flag != nullptr || meanwhile ? kFlagPeriodMs : 1'000'000;
    const int milliseconds = static_cast<int>(std::clamp<std::int64_t>(left.count(), 0, longest));
    pollfd event{handle, POLLIN, 0};
    const int ready = handle >= 0 ? ::poll(&event, 1, milliseconds) : -1;
    if (ready > 0) break;
    if (handle < 0) {  // no pidfd on this kernel: look every few milliseconds
      siginfo_t info{};
      if (::waitid(P_PID, static_cast<id_t>(child), &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
          info.si_pid != 0)
        break;
      ::usleep(2000);
    }
    if (meanwhile) meanwhile();
    const bool stopped = stop_flag != nullptr && *stop_flag != 0;
    if (milliseconds == 0 || stopped) {
      if (handle >= 0) ::close(handle);
      return stopped ? Wait::kStopped : Wait::kTimeUp;
    }
  }
  if (handle >= 0) ::close(handle);
  return Wait::kEnded;
}

/// The reports of palpate_child: why the program could not be started, or how it ended.
struct Reports {
  std::optional<int> start_error;
  std::optional<ChildReport> end;
};

Reports read_reports(int pipe) {
  Reports reports;
  ChildReport report;
  while (::read(pipe, &report, sizeof report) == sizeof report) {
    if (report.kind == ChildReport::kNotStarted) reports.start_error = report.value;
    if (report.kind == ChildReport::kEnded) reports.end = report;
  }
  return reports;
}

void describe_status(int status, ProcessResult& result) {
  if (WIFSIGNALED(status)) {
    result.end = ProcessEnd::kSignalled;
    result.signal = WTERMSIG(status);
    result.message =
        "killed by signal " + std::to_string(result.signal) + " (" + ::strsignal(result.signal) + ")";
  } else {
    result.end = ProcessEnd::kExited;
    result.exit_code = WEXITSTATUS(status);
    result.message = "exit code " + std::to_string(result.exit_code);
  }
}

ProcessResult describe(int child_status, const Reports& reports, Wait wait, const ProcessSpec& spec) {
  ProcessResult result;
  if (reports.end) {
    result.has_usage = true;
    result.user_s = seconds_of(reports.end->usage.ru_utime);
    result.system_s = seconds_of(reports.end->usage.ru_stime);
    result.peak_rss_bytes = static_cast<std::uint64_t>(reports.end->usage.ru_maxrss) * 1024;
  }
  if (reports.start_error) {
    result.end = ProcessEnd::kNotStarted;
    result.message = "cannot start " + spec.arguments[0] + ": " + std::strerror(*reports.start_error);
  } else if (wait == Wait::kStopped) {
    result.end = ProcessEnd::kInterrupted;
    result.message = "interrupted";
  } else if (wait == Wait::kTimeUp) {
    result.end = ProcessEnd::kTimedOut;
    std::string limit = std::to_string(spec.timeout_s);
    limit.erase(limit.find_last_not_of('0') + 1);
    if (!limit.empty() && limit.back() == '.') limit.pop_back();
    result.message = "timed out after " + limit + " s";
  } else {
    describe_status(reports.end ? reports.end->value : child_status, result);
  }
  return result;
}

/// PROGRAM ARGUMENT... behind palpate_child, as execv wants them.
std::vector<char*> command_of(const ProcessSpec& spec) {
  static std::string starter = program_folder() + "/palpate_child";
  std::vector<char*> arguments{starter.data()};
  for (const std::string& a : spec.arguments) arguments.push_back(const_cast<char*>(a.c_str()));
  arguments.push_back(nullptr);
  return arguments;
}

}  // namespace

ProcessResult run_process(const ProcessSpec& spec) {
  require(!spec.arguments.empty(), "run_process: no program");
  ::setenv("LC_ALL", "C", 1);
  ::setenv("OMP_NUM_THREADS", std::to_string(spec.threads).c_str(), 1);
  const std::vector<char*> arguments = command_of(spec);
  std::array<int, 2> report{-1, -1};
  if (::pipe2(report.data(), O_CLOEXEC) != 0) throw UnavailableError("cannot make a pipe");

  const auto start = std::chrono::steady_clock::now();
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child < 0) {
    ::close(report[0]);
    ::close(report[1]);
    throw UnavailableError(std::string("cannot start a process: ") + std::strerror(errno));
  }
  if (child == 0) become(spec, arguments, parent, report[1]);
  ::close(report[1]);
  ::setpgid(child, child);

  const auto limit = std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::chrono::duration<double>(std::min(spec.timeout_s, 1e8)));
  Wait wait = wait_for_end(child, start + limit, spec.stop_flag, spec.while_waiting);
  if (wait == Wait::kStopped && spec.stop_grace_s > 0.0) {
    ::kill(-child, SIGINT);
    const auto grace = std::chrono::duration_cast<std::chrono::steady_clock::duration>(
        std::chrono::duration<double>(std::min(spec.stop_grace_s, 1e8)));
    if (wait_for_end(child, std::chrono::steady_clock::now() + grace, nullptr, {}) == Wait::kEnded)
      wait = Wait::kEnded;
  }
  ::kill(-child, SIGKILL);  // the rest of its group too, once its leader is done or late
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  const double wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  ProcessResult result = describe(status, read_reports(report[0]), wait, spec);
  result.wall_s = wall_s;
  ::close(report[0]);
  return result;
}

}  // namespace palpate::experiments

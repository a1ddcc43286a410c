#include "experiments/processes/process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
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
#include "experiments/processes/child/process_tree.h"
#include "experiments/processes/child/report.h"
#include "experiments/processes/child/sanitizers.h"
#include "experiments/processes/time_bound.h"

namespace palpate::experiments {
namespace {

double seconds_of(const timeval& t) {
  return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
}

void redirect(int target, const std::filesystem::path& path) {
  const char* name = path.empty() ? "/dev/null" : path.c_str();
  const int file = ::open(name, O_WRONLY | O_CREAT | O_TRUNC | O_APPEND | O_CLOEXEC | O_NOFOLLOW, 0644);
  if (file >= 0) ::dup2(file, target);
}

/// The ends that palpate_child gets.
struct ChildEnds {
  int report = -1;
  int orders = -1;
};

/// Puts both where palpate_child looks for them, whatever numbers they have.
void hand_over(const ChildEnds& ends) {
  constexpr int kOutOfTheWay = 10;
  const int report = ::fcntl(ends.report, F_DUPFD_CLOEXEC, kOutOfTheWay);
  const int orders = ::fcntl(ends.orders, F_DUPFD_CLOEXEC, kOutOfTheWay);
  ::dup2(report, kChildReportFile);
  ::dup2(orders, kChildOrderFile);
}

void bound_resource(decltype(RLIMIT_AS) kind, std::uint64_t most) {
  const rlimit bound{most, most};
  ::setrlimit(kind, &bound);
}

/// Runs in the child between fork and exec: only calls that are safe there.
[[noreturn]] void become(const ProcessSpec& spec, const std::vector<char*>& arguments,
                         const ChildEnds& ends) {
  ::setpgid(0, 0);
  for (const int number : {SIGPIPE, SIGXFSZ})
    ::signal(number, SIG_DFL);  // ignored here, and exec hands that on
  const int null = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (null >= 0) ::dup2(null, STDIN_FILENO);
  redirect(STDOUT_FILENO, spec.standard_output);
  redirect(STDERR_FILENO, spec.standard_error);
  bound_resource(RLIMIT_CORE, 0);
  if (spec.file_bytes > 0) bound_resource(RLIMIT_FSIZE, spec.file_bytes);
  if (spec.memory_bytes > 0 && !kIsSanitized) bound_resource(RLIMIT_AS, spec.memory_bytes);
  hand_over(ends);
  ::execv(arguments[0], arguments.data());
  ChildReport report;
  report.kind = ChildReport::kNotStarted;
  report.value = errno;
  const ssize_t written = ::write(kChildReportFile, &report, sizeof report);
  ::_exit(written == sizeof report ? 127 : 126);
}

enum class Wait { kEnded, kTimeUp, kStopped };

/// Waits until the child ends, the time is up or the stop flag rises.
Wait wait_for_end(pid_t child, TimeBound& bound, const volatile std::sig_atomic_t* stop_flag,
                  const std::function<void()>& meanwhile) {
  constexpr std::int64_t kFlagPeriodMs = 100;
  const int handle = static_cast<int>(::syscall(SYS_pidfd_open, child, 0));
  Wait wait = Wait::kEnded;
  while (true) {
    const int milliseconds = bound.wait_ms(stop_flag != nullptr || meanwhile ? kFlagPeriodMs : 1'000'000);
    pollfd event{handle, POLLIN, 0};
    const int ready = handle >= 0 ? ::poll(&event, 1, milliseconds) : -1;
    const bool was_stopped = bound.look();
    if (ready > 0) break;
    if (was_stopped) continue;
    if (handle < 0) {  // no pidfd on this kernel: look every few milliseconds
      siginfo_t info{};
      if (::waitid(P_PID, static_cast<id_t>(child), &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
          info.si_pid != 0)
        break;
      ::usleep(2000);
    }
    if (meanwhile) meanwhile();
    if (stop_flag != nullptr && *stop_flag != 0) {
      wait = Wait::kStopped;
      break;
    }
    if (bound.is_up()) {
      wait = Wait::kTimeUp;
      break;
    }
  }
  if (handle >= 0) ::close(handle);
  return wait;
}

/// The same for `seconds` from now, whatever the stop flag says. Returns whether the child has ended.
bool ends_within(pid_t child, double seconds) {
  TimeBound bound(seconds);
  return wait_for_end(child, bound, nullptr, {}) == Wait::kEnded;
}

/// Two ends of a channel, closed at the end.
struct Pair {
  Pair() = default;
  ~Pair() {
    close(0);
    close(1);
  }
  Pair(const Pair&) = delete;
  Pair& operator=(const Pair&) = delete;

  void close(std::size_t end) {
    if (ends[end] >= 0) ::close(ends[end]);
    ends[end] = -1;
  }

  std::array<int, 2> ends{-1, -1};
};

/// The reports of palpate_child: why the program could not be started, or how it ended.
struct Reports {
  std::optional<int> start_error;
  std::optional<ChildReport> end;
  bool too_much_memory = false;
};

Reports read_reports(int pipe) {
  Reports reports;
  ::fcntl(pipe, F_SETFL, O_NONBLOCK);  // all that will come is there: who would send it has ended
  ChildReport report;
  while (::read(pipe, &report, sizeof report) == sizeof report) {
    if (report.kind == ChildReport::kNotStarted) reports.start_error = report.value;
    if (report.kind == ChildReport::kEnded || report.kind == ChildReport::kTooMuchMemory)
      reports.end = report;
    reports.too_much_memory = report.kind == ChildReport::kTooMuchMemory;
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
  if (reports.end && wait == Wait::kEnded) {
    result.has_usage = true;
    result.user_s = seconds_of(reports.end->usage.ru_utime);
    result.system_s = seconds_of(reports.end->usage.ru_stime);
    result.peak_rss_bytes = reports.end->peak_bytes;
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
  } else if (reports.too_much_memory) {
    result.end = ProcessEnd::kTooMuchMemory;
    result.message =
        "its processes together took more than " + std::to_string(spec.memory_bytes >> 20U) + " MiB";
  } else if (!reports.end && WIFEXITED(child_status)) {
    // What it starts cannot end it so: it lacked something itself, such as numbers for files.
    throw UnavailableError("palpate_child ended with exit code " + std::to_string(WEXITSTATUS(child_status)) +
                           " before " + spec.arguments[0] + " did");
  } else {
    describe_status(reports.end ? reports.end->value : child_status, result);
  }
  if (reports.end && reports.end->left > 0)
    result.message += "; " + std::to_string(reports.end->left) + " of its processes could not be ended";
  return result;
}

/// PROGRAM ARGUMENT... behind palpate_child and its bound of memory, as execv wants them. `memory` holds the
/// text.
std::vector<char*> command_of(const ProcessSpec& spec, std::string& memory) {
  static std::string starter = program_folder() + "/palpate_child";
  memory = kIsSanitized ? "0" : std::to_string(spec.memory_bytes);
  std::vector<char*> arguments{starter.data(), memory.data()};
  for (const std::string& a : spec.arguments) arguments.push_back(const_cast<char*>(a.c_str()));
  arguments.push_back(nullptr);
  return arguments;
}

void order(int orders, ChildOrder what) {
  const char byte = what;
  ::send(orders, &byte, 1, MSG_NOSIGNAL);  // palpate_child may have gone
}

/// Has all processes below palpate_child killed. It does so itself, woken if somebody stopped it; if it does
/// not, it is helped and then killed too.
void kill_all(pid_t child, int orders) {
  constexpr double kPatienceS = kPatienceWithStormsS + 4.0;  // longer than its own
  constexpr int kTries = 100;
  order(orders, kKillAll);
  ::kill(child, SIGCONT);
  if (ends_within(child, kPatienceS)) return;
  for (int i = 0; i < kTries && !kill_descendants(child).empty(); ++i) ::usleep(1000);
  ::kill(child, SIGKILL);
}

}  // namespace

ProcessResult run_process(const ProcessSpec& spec) {
  require(!spec.arguments.empty(), "run_process: no program");
  ::setenv("LC_ALL", "C", 1);
  ::setenv("OMP_NUM_THREADS", std::to_string(spec.threads).c_str(), 1);
  std::string memory;
  const std::vector<char*> arguments = command_of(spec, memory);
  Pair report;
  Pair orders;
  if (::pipe2(report.ends.data(), O_CLOEXEC) != 0 ||
      ::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, orders.ends.data()) != 0)
    throw UnavailableError("cannot make a pipe");

  const auto start = std::chrono::steady_clock::now();
  TimeBound bound(spec.timeout_s);
  const pid_t child = ::fork();
  if (child < 0) throw UnavailableError(std::string("cannot start a process: ") + std::strerror(errno));
  if (child == 0) become(spec, arguments, {report.ends[1], orders.ends[1]});
  report.close(1);
  orders.close(1);

  Wait wait = wait_for_end(child, bound, spec.stop_flag, spec.while_waiting);
  const double stopped_s = bound.stopped_s();
  if (wait == Wait::kStopped && spec.stop_grace_s > 0.0) {
    order(orders.ends[0], kInterrupt);
    if (ends_within(child, spec.stop_grace_s)) wait = Wait::kEnded;
  }
  if (wait != Wait::kEnded) kill_all(child, orders.ends[0]);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  const double wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  ProcessResult result = describe(status, read_reports(report.ends[0]), wait, spec);
  result.wall_s = wall_s;
  result.stopped_s = stopped_s;
  return result;
}

}  // namespace palpate::experiments

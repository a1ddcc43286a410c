// palpate_child MEMORY_BYTES PROGRAM ARGUMENT...: starts a program, waits for it, leaves no process of it
// behind, and reports its end and what it took.
//
// Linux counts the memory of the process that forks to the peak of the child that it execs. Started from this
// small program, a contestant's peak is its own, however large the runner has grown.
//
// Orphans among its descendants become this program's children (subreaper), so that what left the group and
// the session is found too. It outlives a runner that was killed just long enough to clean up.
#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "experiments/processes/child/process_tree.h"
#include "experiments/processes/child/report.h"

namespace {

using namespace palpate::experiments;

using Clock = std::chrono::steady_clock;

constexpr int kTickMs = 100;
constexpr int kTickWithoutHandleMs = 2;  // kernels without pidfd

bool send(const ChildReport& report) {
  return ::write(kChildReportFile, &report, sizeof report) == sizeof report;
}

void ignore_signals(void (*action)(int)) {
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) std::signal(number, action);
}

[[noreturn]] void become(char** arguments, pid_t parent) {
  ::setpgid(0, 0);  // a group of its own: what it sends to its group does not meet this program
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(127);
  ignore_signals(SIG_DFL);
  ::execv(arguments[0], arguments);
  ChildReport report;
  report.kind = ChildReport::kNotStarted;
  report.value = errno;
  send(report);
  ::_exit(127);
}

/// The number of the youngest process of the machine; 0 if it cannot be told. As long as it stays, nobody has
/// started one.
long youngest_process() {
  std::FILE* file = std::fopen("/proc/loadavg", "r");
  if (file == nullptr) return 0;
  long youngest = 0;
  if (std::fscanf(file, "%*f %*f %*f %*s %ld", &youngest) != 1) youngest = 0;
  std::fclose(file);
  return youngest;
}

/// Memory of the tree, looked at now and then. One process alone is left to the kernel, which knows its peak
/// and its bound exactly.
class TreeMemory {
 public:
  explicit TreeMemory(std::uint64_t bound) : bound_(bound) {}

  /// Whether the tree takes more than its bound.
  bool is_too_much() {
    const Clock::time_point now = Clock::now();
    if (now < next_look_) return false;
    look();
    next_look_ = rest_after(now, kRestOfLook);
    if (processes_.size() < 2 || resident_bytes(processes_) <= peak_ || now < next_exact_look_) return false;
    const Clock::time_point start = Clock::now();
    peak_ = std::max(peak_, proportional_bytes(processes_));
    next_exact_look_ = rest_after(start, kRestOfExactLook);
    return bound_ > 0 && peak_ > bound_;
  }

  std::uint64_t peak() const { return peak_; }

 private:
  // Multiples of what looking takes, by the clock: in a storm of processes there is no end of it otherwise.
  static constexpr int kRestOfLook = 10;
  static constexpr int kRestOfExactLook = 50;

  static Clock::time_point rest_after(Clock::time_point start, int times) {
    const Clock::time_point now = Clock::now();
    return now + times * (now - start);
  }

  void look() {
    const long youngest = youngest_process();
    if (youngest == 0 || youngest != youngest_) processes_ = find_descendants(::getpid());
    youngest_ = youngest;
  }

  std::uint64_t bound_;
  std::uint64_t peak_ = 0;
  std::vector<pid_t> processes_;
  long youngest_ = 0;
  Clock::time_point next_look_{};
  Clock::time_point next_exact_look_{};
};

/// Gives the disk back what lies before the end of a flood. What is written meanwhile is not touched: the
/// file keeps its length, with a hole at its begin. Returns: whether that can be done, for a file of this
/// length.
bool punch_flood(off_t size, off_t kept) {
  // Far below what a file may be: the writer would be ended there.
  constexpr off_t kLongest = off_t{1} << 30U;
  return size < kLongest &&
         ::fallocate(STDERR_FILENO, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, 0, size - kept) == 0;
}

/// A flood on standard error is cut off before it fills the disk. Its end is what matters, so that is kept:
/// the file is written by appending, and what comes later stands behind it. While somebody may still write
/// (`is_live`) the file is shortened only where nothing else helps: the end could come in that moment.
void cut_flood(bool is_live) {
  constexpr off_t kMost = off_t{16} << 20U;
  constexpr std::size_t kKept = std::size_t{64} << 10U;
  static off_t freed = 0;
  struct stat status {};
  if (::fstat(STDERR_FILENO, &status) != 0 || !S_ISREG(status.st_mode) || status.st_size <= kMost) return;
  freed = std::min(freed, status.st_size);
  if (is_live && status.st_size - freed <= kMost) return;
  if (is_live && punch_flood(status.st_size, static_cast<off_t>(kKept))) {
    freed = status.st_size - static_cast<off_t>(kKept);
    return;
  }
  freed = 0;
  static char kept[kKept];
  constexpr int kTries = 8;
  const int file = ::open("/proc/self/fd/2", O_RDONLY | O_CLOEXEC);  // ours may only write
  ssize_t got = 0;
  off_t seen = -1;
  for (int i = 0; i < kTries && seen != status.st_size; ++i) {  // what is written meanwhile may be the end
    seen = status.st_size;
    got = file >= 0 ? ::pread(file, kept, kKept, seen - static_cast<off_t>(kKept)) : 0;
    if (::fstat(STDERR_FILENO, &status) != 0) break;
  }
  if (file >= 0) ::close(file);
  if (::ftruncate(STDERR_FILENO, 0) != 0) return;
  constexpr char kNote[] = "(more than 16 MiB before this were cut off)\n";
  if (::write(STDERR_FILENO, kNote, sizeof kNote - 1) < 0) return;
  if (got > 0 && ::write(STDERR_FILENO, kept, static_cast<std::size_t>(got)) < 0) return;
}

enum class Watch { kEnded, kKill, kTooMuchMemory };

enum class Collected { kAll, kSome, kNobodyLeft };

/// Collects children that have ended, so many at most: where they start one another and end there is always
/// one more, and orders have to be heard beside that. Returns: kSome if more may wait, kNobodyLeft if there
/// is no child at all.
Collected collect(pid_t program, int most, int& status, bool& has_ended) {
  for (int i = 0; i < most; ++i) {
    int each = 0;
    const pid_t child = ::waitpid(-1, &each, WNOHANG);
    if (child < 0) return errno == ECHILD ? Collected::kNobodyLeft : Collected::kAll;
    if (child == 0) return Collected::kAll;
    if (child != program) continue;
    status = each;
    has_ended = true;
  }
  return Collected::kSome;
}

/// The next order; kKillAll where nobody gives any more.
char read_order() {
  char order = kKillAll;
  const ssize_t got = ::read(kChildOrderFile, &order, 1);
  if (got < 0 && errno == EINTR) return 0;
  return got == 1 ? order : static_cast<char>(kKillAll);
}

Watch watch(pid_t program, TreeMemory& memory, int& status) {
  const int handle = static_cast<int>(::syscall(SYS_pidfd_open, program, 0));
  constexpr int kMostAtOnce = 64;  // between two looks at the orders
  const int tick_ms = handle >= 0 ? kTickMs : kTickWithoutHandleMs;
  bool has_ended = false;
  Collected last = Collected::kAll;
  Watch seen = Watch::kEnded;
  while (true) {
    pollfd files[2] = {{kChildOrderFile, POLLIN, 0}, {handle, POLLIN, 0}};
    ::poll(files, handle >= 0 ? 2 : 1, last == Collected::kSome ? 0 : tick_ms);
    last = collect(program, kMostAtOnce, status, has_ended);
    if (has_ended) break;
    const char order = files[0].revents != 0 ? read_order() : '\0';
    if (order == kInterrupt) ::kill(-program, SIGINT);
    if (order == kKillAll) {
      seen = Watch::kKill;
      break;
    }
    cut_flood(true);
    if (memory.is_too_much()) {
      seen = Watch::kTooMuchMemory;
      break;
    }
  }
  if (handle >= 0) ::close(handle);
  return seen;
}

/// Kills the children of this program, as the system lists them at once: a process that starts another and
/// ends hands it on to this program, and is met here before the next listing of all has come to its end.
void kill_children() {
  char path[64];
  std::snprintf(path, sizeof path, "/proc/self/task/%d/children", static_cast<int>(::getpid()));
  std::FILE* file = std::fopen(path, "r");
  if (file == nullptr) return;  // kernels without it
  int child = 0;
  while (std::fscanf(file, "%d", &child) == 1) ::kill(child, SIGKILL);
  std::fclose(file);
}

/// Kills what is left and collects it. Gives up on what cannot be killed (it waits for a broken disk, or runs
/// as another user) once nothing has changed for a while, and on a storm that outruns it at the very end.
/// Returns: how many are left.
std::size_t clean_up(pid_t program, int& status) {
  constexpr int kMostAtOnce = 4096;  // children, between two looks at all processes
  constexpr int kLooksAtChildren = 8;
  constexpr unsigned kShortestWaitUs = 200;
  constexpr unsigned kLongestWaitUs = 50'000;
  const Clock::time_point end = Clock::now() + std::chrono::seconds(kPatienceWithStormsS);
  Clock::time_point changed = Clock::now();
  unsigned wait_us = kShortestWaitUs;
  bool has_ended = false;
  std::vector<pid_t> last;
  while (collect(program, kMostAtOnce, status, has_ended) != Collected::kNobodyLeft) {
    const std::vector<pid_t> found = kill_descendants(::getpid());
    const Clock::time_point now = Clock::now();
    if (now > end || (found == last && now > changed + std::chrono::seconds(kPatienceS))) return found.size();
    if (found == last) {
      ::usleep(wait_us);
      wait_us = std::min(2 * wait_us, kLongestWaitUs);
      continue;
    }
    changed = now;
    wait_us = kShortestWaitUs;
    last = found;
    for (int i = 0; i < kLooksAtChildren; ++i) {
      if (collect(program, kMostAtOnce, status, has_ended) == Collected::kNobodyLeft) return 0;
      kill_children();
    }
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return 126;
  ::fcntl(kChildReportFile, F_SETFD, FD_CLOEXEC);
  ::fcntl(kChildOrderFile, F_SETFD, FD_CLOEXEC);
  ::prctl(PR_SET_CHILD_SUBREAPER, 1);
  ignore_signals(SIG_IGN);
  const pid_t self = ::getpid();
  const pid_t program = ::fork();
  if (program == 0) become(argv + 2, self);
  ChildReport report;
  if (program < 0) {
    report.kind = ChildReport::kNotStarted;
    report.value = errno;
    return send(report) ? 127 : 126;
  }
  ::setpriority(PRIO_PROCESS, 0, -20);  // where it may: a storm leaves little of the processor to others
  TreeMemory memory(std::strtoull(argv[1], nullptr, 10));
  const Watch seen = watch(program, memory, report.value);
  report.left = clean_up(program, report.value);
  cut_flood(report.left > 0);  // what came since the last look
  report.kind = seen == Watch::kTooMuchMemory ? ChildReport::kTooMuchMemory : ChildReport::kEnded;
  ::getrusage(RUSAGE_CHILDREN, &report.usage);
  report.peak_bytes = std::max(memory.peak(), static_cast<std::uint64_t>(report.usage.ru_maxrss) * 1024);
  return send(report) ? 0 : 126;
}

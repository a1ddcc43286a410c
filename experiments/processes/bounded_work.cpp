#include "experiments/processes/bounded_work.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <fstream>
#include <new>
#include <vector>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "experiments/processes/child/sanitizers.h"
#include "experiments/processes/time_bound.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

/// The child's first byte: what follows is the value (CBOR) or the message of an exception.
enum Kind : char { kValue = 'v', kInput = 'i', kUnavailable = 'u', kMemory = 'm', kJson = 'j', kOther = 'o' };

void send(int file, Kind kind, const char* data, std::size_t bytes) {
  const auto write_all = [file](const char* at, std::size_t left) {
    while (left > 0) {
      const ssize_t written = ::write(file, at, left);
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) ::_exit(1);
      at += written;
      left -= static_cast<std::size_t>(written);
    }
  };
  const char first = kind;
  write_all(&first, 1);
  write_all(data, bytes);
}

void send_text(int file, Kind kind, const char* text) {
  send(file, kind, text, std::strlen(text));
}

/// Bytes of address space that this process has. Reading them takes and gives back some, so that two readings
/// may differ.
std::uint64_t own_size() {
  std::uint64_t pages = 0;
  if (!(std::ifstream("/proc/self/statm") >> pages))
    throw UnavailableError("cannot tell the size of a process: expected it in /proc/self/statm");
  return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

void bound_memory(std::uint64_t bytes) {
  if (bytes == 0 || kIsSanitized) return;
  rlimit bound{};
  ::getrlimit(RLIMIT_AS, &bound);
  bound.rlim_cur = std::min<std::uint64_t>(own_size() + bytes, bound.rlim_max);
  bound.rlim_max = bound.rlim_cur;
  if (::setrlimit(RLIMIT_AS, &bound) != 0)
    throw UnavailableError(std::string("cannot bound the memory of a process: ") + std::strerror(errno));
}

/// The child's side.
[[noreturn]] void work_and_send(const std::function<json()>& work, std::uint64_t memory_bytes, int file) {
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
  try {
    bound_memory(memory_bytes);
    const std::vector<std::uint8_t> bytes = json::to_cbor(work());
    send(file, kValue, reinterpret_cast<const char*>(bytes.data()), bytes.size());
  } catch (const InputError& error) {
    send_text(file, kInput, error.what());
  } catch (const UnavailableError& error) {
    send_text(file, kUnavailable, error.what());
  } catch (const json::exception& error) {
    send_text(file, kJson, error.what());
  } catch (const std::bad_alloc&) {
    send_text(file, kMemory, "");
  } catch (const std::exception& error) {
    send_text(file, kOther, error.what());
  }
  ::_exit(0);
}

enum class Arrival { kWhole, kLate, kStopped };

/// Reads to the end of the pipe.
Arrival receive(int file, double timeout_s, const volatile std::sig_atomic_t* stop_flag,
                std::vector<char>& bytes) {
  constexpr std::int64_t kFlagPeriodMs = 100;
  std::array<char, 65536> block{};
  for (TimeBound bound(timeout_s); !bound.is_up(); bound.look()) {
    if (stop_flag != nullptr && *stop_flag != 0) return Arrival::kStopped;
    pollfd item{file, POLLIN, 0};
    if (::poll(&item, 1, bound.wait_ms(kFlagPeriodMs)) <= 0) continue;
    const ssize_t got = ::read(file, block.data(), block.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return Arrival::kWhole;
    bytes.insert(bytes.end(), block.data(), block.data() + got);
  }
  return Arrival::kLate;
}

WorkResult ended(WorkEnd end, std::string message) {
  WorkResult result;
  result.end = end;
  result.message = std::move(message);
  return result;
}

/// What the bytes of a child that came to its end mean.
WorkResult open_answer(const std::vector<char>& bytes, int status, const WorkBounds& bounds) {
  if (bytes.empty() || !WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    const std::string how = WIFSIGNALED(status) ? "was ended by signal " + std::to_string(WTERMSIG(status))
                                                : std::string("ended without a result");
    return ended(WorkEnd::kCrashed, how);
  }
  const std::string text(bytes.begin() + 1, bytes.end());
  switch (bytes.front()) {
    case kInput:
      throw InputError(text);
    case kUnavailable:
      throw UnavailableError(text);
    case kJson:
      throw InputError(text);
    case kMemory:
      return ended(WorkEnd::kOutOfMemory,
                   "needed more than " + std::to_string(bounds.memory_bytes >> 20U) + " MiB of memory");
    case kValue:
      break;
    default:
      throw ContractError(text);
  }
  WorkResult result;
  result.end = WorkEnd::kDone;
  result.value = json::from_cbor(text);
  return result;
}

}  // namespace

WorkResult run_bounded(const std::function<json()>& work, const WorkBounds& bounds) {
  std::array<int, 2> ends{-1, -1};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) throw UnavailableError("cannot make a pipe");
  std::fflush(nullptr);
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(1);
    ::close(ends[0]);
    work_and_send(work, bounds.memory_bytes, ends[1]);
  }
  ::close(ends[1]);
  if (child < 0) {
    ::close(ends[0]);
    throw UnavailableError(std::string("cannot start a process: ") + std::strerror(errno));
  }
  std::vector<char> bytes;
  const Arrival arrival = receive(ends[0], bounds.timeout_s, bounds.stop_flag, bytes);
  ::close(ends[0]);
  if (arrival != Arrival::kWhole) ::kill(child, SIGKILL);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (arrival == Arrival::kStopped) return ended(WorkEnd::kInterrupted, "interrupted");
  if (arrival == Arrival::kLate)
    return ended(WorkEnd::kTimedOut, "took longer than " + short_number(bounds.timeout_s) + " s");
  return open_answer(bytes, status, bounds);
}

}  // namespace palpate::experiments

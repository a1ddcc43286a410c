#include "reference/simplifier_support/isolated_run.h"

#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>
#include <stdexcept>

#include "core/base/error.h"

namespace palpate::reference {
namespace {

using Clock = std::chrono::steady_clock;

/// What goes through the pipe first; then the points and tets, or the message.
struct Header {
  enum Kind : std::uint32_t { kMesh, kInputError, kError } kind = kError;
  double kernel_s = 0.0;
  std::uint64_t points = 0;
  std::uint64_t tets = 0;
  std::uint64_t message_bytes = 0;
};

void write_all(int file, const void* data, std::size_t bytes) {
  const char* at = static_cast<const char*>(data);
  while (bytes > 0) {
    const ssize_t written = ::write(file, at, bytes);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) ::_exit(1);
    at += written;
    bytes -= static_cast<std::size_t>(written);
  }
}

void send_message(int file, Header::Kind kind, const char* text) {
  Header header;
  header.kind = kind;
  header.message_bytes = std::strlen(text);
  write_all(file, &header, sizeof header);
  write_all(file, text, header.message_bytes);
}

/// The child's side.
[[noreturn]] void work_and_send(const std::function<TimedMesh()>& work, int file) {
  try {
    const TimedMesh result = work();
    Header header;
    header.kind = Header::kMesh;
    header.kernel_s = result.kernel_s;
    header.points = result.mesh.points.size();
    header.tets = result.mesh.tets.size();
    write_all(file, &header, sizeof header);
    write_all(file, result.mesh.points.data(), result.mesh.points.size() * sizeof(Vec3));
    write_all(file, result.mesh.tets.data(), result.mesh.tets.size() * sizeof(Tet));
  } catch (const InputError& error) {
    send_message(file, Header::kInputError, error.what());
  } catch (const std::exception& error) {
    send_message(file, Header::kError, error.what());
  } catch (...) {
    send_message(file, Header::kError, "an exception of unknown type");
  }
  std::fflush(nullptr);
  ::_exit(0);
}

/// The parent's side of the pipe.
class Receiver {
 public:
  Receiver(int file, Clock::time_point deadline) : file_(file), deadline_(deadline) {}

  /// Whether all bytes came before the end of the pipe or the deadline.
  bool receive(void* data, std::size_t bytes) {
    char* at = static_cast<char*>(data);
    while (bytes > 0) {
      if (!wait_for_data()) return false;
      const ssize_t got = ::read(file_, at, bytes);
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) return false;
      at += got;
      bytes -= static_cast<std::size_t>(got);
    }
    return true;
  }

  bool is_late() const { return late_; }

 private:
  bool wait_for_data() {
    while (true) {
      const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline_ - Clock::now());
      if (left.count() <= 0) {
        late_ = true;
        return false;
      }
      pollfd item{file_, POLLIN, 0};
      const int ready = ::poll(&item, 1, static_cast<int>(std::min<std::int64_t>(left.count() + 1, 60000)));
      if (ready > 0) return true;
      if (ready < 0 && errno != EINTR) return false;
    }
  }

  int file_;
  Clock::time_point deadline_;
  bool late_ = false;
};

/// Whether a whole answer came; `message` is filled for a failure that the child told.
bool receive_answer(Receiver& receiver, Header& header, TimedMesh& result, std::string& message) {
  if (!receiver.receive(&header, sizeof header)) return false;
  if (header.kind != Header::kMesh) {
    message.resize(header.message_bytes);
    return receiver.receive(message.data(), message.size());
  }
  result.kernel_s = header.kernel_s;
  result.mesh.points.resize(header.points);
  result.mesh.tets.resize(header.tets);
  return receiver.receive(result.mesh.points.data(), header.points * sizeof(Vec3)) &&
         receiver.receive(result.mesh.tets.data(), header.tets * sizeof(Tet));
}

int wait_for(pid_t child) {
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

/// A child that ends when this process does; 0 in the child.
pid_t fork_bound() {
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child < 0) throw std::runtime_error(std::string("cannot start a process: ") + std::strerror(errno));
  if (child > 0) return child;
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(1);
  return 0;
}

std::string first_line(const std::string& text) {
  return text.substr(0, text.find('\n'));
}

}  // namespace

TimedMesh run_isolated(const std::function<TimedMesh()>& work, double time_limit_s) {
  std::array<int, 2> ends{-1, -1};
  if (::pipe(ends.data()) != 0) throw std::runtime_error("cannot make a pipe");
  std::fflush(nullptr);
  const pid_t child = fork_bound();
  if (child == 0) {
    ::close(ends[0]);
    work_and_send(work, ends[1]);
  }
  ::close(ends[1]);
  const auto limit = std::chrono::duration<double>(std::min(time_limit_s, 1e8));
  Receiver receiver(ends[0], Clock::now() + std::chrono::duration_cast<Clock::duration>(limit));
  Header header;
  TimedMesh result;
  std::string message;
  const bool whole = receive_answer(receiver, header, result, message);
  ::close(ends[0]);
  if (!whole) ::kill(child, SIGKILL);
  const int status = wait_for(child);
  if (whole && header.kind == Header::kMesh) return result;
  if (whole && header.kind == Header::kInputError) throw InputError(first_line(message));
  if (whole) throw std::runtime_error(first_line(message));
  if (receiver.is_late()) {
    throw std::runtime_error("stopped after " + std::to_string(static_cast<std::int64_t>(time_limit_s)) +
                             " s");
  }
  if (WIFSIGNALED(status) && WTERMSIG(status) != SIGKILL) {
    throw std::runtime_error("crashed by signal " + std::to_string(WTERMSIG(status)));
  }
  throw std::runtime_error("ended without a result");
}

int run_program(const std::vector<std::string>& arguments) {
  std::vector<char*> pointers;
  pointers.reserve(arguments.size() + 1);
  for (const std::string& argument : arguments) pointers.push_back(const_cast<char*>(argument.c_str()));
  pointers.push_back(nullptr);
  const pid_t child = fork_bound();
  if (child == 0) {
    ::execv(pointers[0], pointers.data());
    ::_exit(127);
  }
  const int status = wait_for(child);
  if (!WIFEXITED(status)) {
    throw std::runtime_error(arguments[0] + " was ended by signal " + std::to_string(WTERMSIG(status)));
  }
  if (WEXITSTATUS(status) == 127) throw std::runtime_error(arguments[0] + " cannot be started");
  return WEXITSTATUS(status);
}

}  // namespace palpate::reference

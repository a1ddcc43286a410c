#include "experiments/live/live_server.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "experiments/live/live_request.h"

namespace palpate::experiments {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kMostHeadBytes = 16384;
constexpr int kLookUpMs = 200;  ///< how often the stop flag is looked at

/// A socket, closed at the end.
class Socket {
 public:
  explicit Socket(int fd) : fd_(fd) {}
  ~Socket() {
    if (fd_ >= 0) ::close(fd_);
  }
  Socket(Socket&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Socket& operator=(Socket&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  int fd() const { return fd_; }

 private:
  int fd_;
};

/// One visitor: what was read, and how far the answer is.
struct Visitor {
  Socket socket;
  std::string request;
  LiveReply reply;
  bool is_answered = false;
  std::size_t sent = 0;
  Clock::time_point came = Clock::now();
  Clock::time_point last = came;  ///< when it took or sent something
};

Socket open_socket(std::uint16_t port) {
  Socket socket(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int yes = 1;
  if (socket.fd() >= 0) ::setsockopt(socket.fd(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  if (socket.fd() < 0 || ::bind(socket.fd(), reinterpret_cast<sockaddr*>(&address), sizeof address) != 0 ||
      ::listen(socket.fd(), 16) != 0)
    throw UnavailableError("127.0.0.1:" + std::to_string(port) +
                           " cannot be served: " + std::strerror(errno));
  return socket;
}

std::uint16_t port_of(const Socket& socket) {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  if (::getsockname(socket.fd(), reinterpret_cast<sockaddr*>(&address), &size) != 0)
    throw UnavailableError(std::string("the served port cannot be told: ") + std::strerror(errno));
  return ntohs(address.sin_port);
}

/// Reads what is there; answers once the head is whole. False: the visitor is to go.
bool read_some(Visitor& visitor, std::uint16_t port, std::size_t page_bytes) {
  std::array<char, 4096> buffer{};
  const ssize_t got = ::recv(visitor.socket.fd(), buffer.data(), buffer.size(), 0);
  if (got <= 0) return got < 0 && (errno == EAGAIN || errno == EINTR);
  visitor.request.append(buffer.data(), static_cast<std::size_t>(got));
  const std::size_t end = visitor.request.find("\r\n\r\n");
  if (end == std::string::npos) return visitor.request.size() <= kMostHeadBytes;
  visitor.reply = answer_live_request(std::string_view(visitor.request).substr(0, end + 4), port, page_bytes);
  visitor.is_answered = true;
  return true;
}

/// Sends some of the answer. False: all is sent, or the visitor has left.
bool send_some(Visitor& visitor, const std::string& page) {
  const std::string& head = visitor.reply.head;
  const std::string& body = visitor.reply.sends_page ? page : visitor.reply.text;
  const bool in_head = visitor.sent < head.size();
  const std::string& part = in_head ? head : body;
  const std::size_t at = in_head ? visitor.sent : visitor.sent - head.size();
  if (at < part.size()) {
    const ssize_t put = ::send(visitor.socket.fd(), part.data() + at, part.size() - at, MSG_NOSIGNAL);
    if (put < 0) return errno == EAGAIN || errno == EINTR;
    visitor.sent += static_cast<std::size_t>(put);
  }
  return visitor.sent < head.size() + body.size();
}

/// Whether the door is to be watched on: not where a visitor was there and could not be let in (no more file
/// descriptors), until the next look.
bool take_visitors(const Socket& door, std::size_t most, std::vector<Visitor>& visitors) {
  while (visitors.size() < most) {
    Socket socket(::accept4(door.fd(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (socket.fd() < 0) return errno == EAGAIN || errno == EINTR || errno == ECONNABORTED;
    visitors.push_back({std::move(socket), {}, {}});
  }
  return true;
}

/// Whether a visitor has been here for longer than it may.
bool is_late(const Visitor& visitor, const LiveBounds& bounds, Clock::time_point now) {
  if (!visitor.is_answered) return now - visitor.came >= bounds.request;
  return now - visitor.last >= bounds.silence || now - visitor.came >= bounds.answer;
}

}  // namespace

std::size_t serve_live_page(const std::string& page, std::uint16_t port,
                            const volatile std::sig_atomic_t& stop,
                            const std::function<void(std::uint16_t)>& on_ready, const LiveBounds& bounds) {
  const Socket door = open_socket(port);
  const std::uint16_t own = port_of(door);
  on_ready(own);
  std::vector<Visitor> visitors;
  std::size_t looks = 0;
  for (bool is_open = true; stop == 0; ++looks) {
    // Who waits at a door that nobody opens would end every wait at once.
    const bool is_watched = is_open && visitors.size() < bounds.connections;
    std::vector<pollfd> waiting{{is_watched ? door.fd() : -1, POLLIN, 0}};
    for (const Visitor& visitor : visitors)
      waiting.push_back({visitor.socket.fd(), static_cast<short>(visitor.is_answered ? POLLOUT : POLLIN), 0});
    if (::poll(waiting.data(), waiting.size(), kLookUpMs) < 0 && errno != EINTR)
      throw UnavailableError(std::string("waiting for visitors failed: ") + std::strerror(errno));
    for (std::size_t k = 0; k < visitors.size(); ++k) {
      Visitor& visitor = visitors[k];
      bool stays = !is_late(visitor, bounds, Clock::now());
      if (stays && waiting[k + 1].revents != 0) {
        visitor.last = Clock::now();
        stays = visitor.is_answered ? send_some(visitor, page) : read_some(visitor, own, page.size());
      }
      if (!stays) visitor.socket = Socket(-1);
    }
    std::erase_if(visitors, [](const Visitor& visitor) { return visitor.socket.fd() < 0; });
    is_open = take_visitors(door, bounds.connections, visitors);
  }
  return looks;
}

}  // namespace palpate::experiments

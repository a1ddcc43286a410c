#include "experiments/live/live_request.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>

namespace palpate::experiments {
namespace {

std::string lower(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return out;
}

std::string_view trimmed(std::string_view text) {
  const auto is_space = [](char c) { return c == ' ' || c == '\t'; };
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

/// The line at `at`, which moves behind its end.
std::optional<std::string_view> next_line(std::string_view head, std::size_t& at) {
  const std::size_t end = head.find("\r\n", at);
  if (end == std::string_view::npos) return std::nullopt;
  const std::string_view line = head.substr(at, end - at);
  at = end + 2;
  return line;
}

struct LiveRequest {
  std::string method;
  std::string target;
  std::optional<std::string> host;  ///< nothing: none, or two
  std::optional<std::string> origin;
};

std::optional<LiveRequest> parse(std::string_view head) {
  std::size_t at = 0;
  const auto first = next_line(head, at);
  if (!first) return std::nullopt;
  const std::size_t one = first->find(' ');
  const std::size_t two = first->rfind(' ');
  if (one == std::string_view::npos || two <= one || !first->substr(two + 1).starts_with("HTTP/1."))
    return std::nullopt;
  LiveRequest request{std::string(first->substr(0, one)), std::string(first->substr(one + 1, two - one - 1)),
                      std::nullopt, std::nullopt};
  for (auto line = next_line(head, at); line && !line->empty(); line = next_line(head, at)) {
    const std::size_t colon = line->find(':');
    if (colon == std::string_view::npos) return std::nullopt;
    const std::string name = lower(line->substr(0, colon));
    auto& into = name == "host" ? request.host : request.origin;
    if (name != "host" && name != "origin") continue;
    if (into) return std::nullopt;
    into = lower(trimmed(line->substr(colon + 1)));
  }
  return request;
}

const char* reason_of(int status) {
  switch (status) {
    case 200:
      return "OK";
    case 403:
      return "Forbidden";
    case 404:
      return "Not Found";
    case 405:
      return "Method Not Allowed";
    default:
      return "Bad Request";
  }
}

int status_of(const std::optional<LiveRequest>& request, std::uint16_t port) {
  if (!request || !request->host) return 400;
  const std::string end = ":" + std::to_string(port);
  const std::array hosts{"127.0.0.1" + end, "localhost" + end};
  const auto is_own = [&](const std::string& host) { return host == hosts[0] || host == hosts[1]; };
  if (!is_own(*request->host)) return 403;
  if (request->origin && *request->origin != "http://" + *request->host) return 403;
  if (request->method != "GET" && request->method != "HEAD") return 405;
  return request->target == "/" ? 200 : 404;
}

}  // namespace

LiveReply answer_live_request(std::string_view head, std::uint16_t port, std::size_t page_bytes) {
  const std::optional<LiveRequest> request = parse(head);
  LiveReply reply;
  reply.status = status_of(request, port);
  const bool is_good = reply.status == 200;
  const bool is_head = request && request->method == "HEAD";
  reply.sends_page = is_good && !is_head;
  const std::string line = std::to_string(reply.status) + " " + reason_of(reply.status);
  if (!is_good && !is_head) reply.text = line + "\n";
  const std::size_t bytes = is_good ? page_bytes : line.size() + 1;
  reply.head = "HTTP/1.1 " + line + "\r\nContent-Type: " + (is_good ? "text/html" : "text/plain") +
               "; charset=utf-8\r\nContent-Length: " + std::to_string(bytes) +
               "\r\nCache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n"
               "Cross-Origin-Resource-Policy: same-origin\r\nX-Frame-Options: DENY\r\nReferrer-Policy: "
               "no-referrer\r\n" +
               (reply.status == 405 ? "Allow: GET, HEAD\r\n" : "") + "Connection: close\r\n\r\n";
  return reply;
}

}  // namespace palpate::experiments

// What the loopback server makes of a request: one page for one host, and nothing else.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace palpate::experiments {

/// An answer without its body.
struct LiveReply {
  int status = 400;
  bool sends_page = false;  ///< the page follows; else a line of text
  std::string head;         ///< status line and headers, with the empty line
  std::string text;         ///< the line, if the page is not sent
};

/// Answers the head of a request (up to and with its empty line): GET or HEAD of "/" by a Host of 127.0.0.1
/// or localhost with the server's port, and an Origin, if there is one, of the same. So no other page that
/// the browser has open, and no name that somebody points at this machine, gets anything. Else 400 (no
/// request of HTTP/1), 403 (another host or origin), 404 or 405.
LiveReply answer_live_request(std::string_view head, std::uint16_t port, std::size_t page_bytes);

}  // namespace palpate::experiments

// A page served on the loopback, by the program itself.
#pragma once

#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

namespace palpate::experiments {

/// What visitors may take.
struct LiveBounds {
  std::size_t connections = 64;                   ///< at a time; more wait
  std::chrono::milliseconds request{30'000};      ///< until it is whole, however it comes
  std::chrono::milliseconds silence{30'000};      ///< of who is sent an answer and takes none of it
  std::chrono::milliseconds answer{10 * 60'000};  ///< until all of it is taken
};

/// Serves `page` on 127.0.0.1 until `stop` turns non-zero. `port` 0 takes a free one; `on_ready` gets the one
/// that is served. Returns: how often it woke up to look for something to do.
/// Throws: UnavailableError if the port cannot be had.
std::size_t serve_live_page(const std::string& page, std::uint16_t port,
                            const volatile std::sig_atomic_t& stop,
                            const std::function<void(std::uint16_t)>& on_ready,
                            const LiveBounds& bounds = {});

}  // namespace palpate::experiments

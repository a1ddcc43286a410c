// A page served on the loopback, by the program itself.
#pragma once

#include <csignal>
#include <cstdint>
#include <functional>
#include <string>

namespace palpate::experiments {

/// Serves `page` on 127.0.0.1 until `stop` turns non-zero. `port` 0 takes a free one; `on_ready` gets the one
/// that is served. Throws: UnavailableError if the port cannot be had.
void serve_live_page(const std::string& page, std::uint16_t port, const volatile std::sig_atomic_t& stop,
                     const std::function<void(std::uint16_t)>& on_ready);

}  // namespace palpate::experiments

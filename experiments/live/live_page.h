// A live page: one file that holds the engine, the script and the body.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "experiments/live/live_body.h"

namespace palpate::experiments {

/// The body as the page reads it (palpate/live/1): a description, and one run of little-endian bytes in which
/// every array begins at a multiple of eight.
struct LiveBytes {
  nlohmann::json description;
  std::string bytes;
};

/// Packs it. Arrays are named in the description as {"type": "f64", "at": 0, "count": 3}.
LiveBytes pack_live(const LiveBodyData& body);

/// Throws: UnavailableError, with what to install, if the build has no page or no engine.
void check_live_parts();

/// The whole page. Throws: as check_live_parts.
std::string write_live_page(const LiveBodyData& body);

/// Bytes as base64 (RFC 4648).
std::string base64_of(const std::string& bytes);

/// A JSON text or a script that can stand inside of <script>: no "</" and no "<!--" is left in it, and of
/// JSON no "<" at all.
std::string escape_for_script(std::string text, bool is_json);

}  // namespace palpate::experiments

#include "experiments/plan_reader/case_id.h"

#include "experiments/files/file_hash.h"

namespace palpate::experiments {
namespace {

constexpr std::size_t kLongest = 100;  // two parts and an ending fit into a name of 255 bytes
constexpr std::size_t kKept = 60;

bool is_plain(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
         std::string_view("._-+,:").find(c) != std::string_view::npos;
}

}  // namespace

std::string safe_part(std::string_view text) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  std::string part;
  for (const char c : text) {
    const bool leads_up = part.empty() && c == '.' && text.find_first_not_of('.') == std::string_view::npos;
    if (is_plain(c) && !leads_up) {
      part += c;
      continue;
    }
    const auto byte = static_cast<unsigned char>(c);
    part += '%';
    part += kDigits[byte >> 4U];
    part += kDigits[byte & 15U];
  }
  if (part.size() <= kLongest) return part;
  const std::string hash = hash_bytes(text);
  return part.substr(0, kKept) + "%~" + hash.substr(hash.find(':') + 1);
}

std::string case_part(std::string_view name, std::string_view value) {
  return safe_part(name) + "=" + safe_part(value);
}

}  // namespace palpate::experiments

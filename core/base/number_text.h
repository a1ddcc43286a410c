// Numbers as text that reads back to the same bits.
#pragma once

#include <array>
#include <charconv>
#include <string>

namespace palpate {

/// Appends an integer, or a double in the shortest form that reads back to the same bits. The locale plays no
/// part.
template <typename Number>
void append_number(std::string& text, Number value) {
  std::array<char, 32> digits;
  const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  text.append(digits.data(), end);
}

}  // namespace palpate

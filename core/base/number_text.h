// Numbers as text that reads back to the same bits.
#pragma once

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
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

/// A number for a person: up to 6 significant digits, whole numbers below 1e15 whole.
inline std::string short_number(double value) {
  std::array<char, 32> text{};
  const bool whole = value == std::floor(value) && std::fabs(value) < 1e15;
  std::snprintf(text.data(), text.size(), whole ? "%.0f" : "%.6g", value);
  return text.data();
}

/// Three significant digits: "0.0443", "5.73", "1.2e-05".
inline std::string three_digits(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g", value);
  return text.data();
}

}  // namespace palpate

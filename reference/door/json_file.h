// The one reader of JSON: files and answers that somebody else wrote, with bounds on what they may hold. And
// null, which stands for NaN, for an infinity and for what is missing: JSON has no number for them.
#pragma once

#include <cmath>
#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace palpate::reference {

/// What a text may hold. Deep nesting would overflow the stack of whoever walks through it.
struct JsonBounds {
  std::size_t bytes = std::size_t{1} << 30U;
  std::size_t depth = 64;  ///< lists and objects within one another
};

/// The JSON in `text`; `where` names it in messages. Objects keep the order of the text in an ordered_json.
/// Throws: InputError with the line, if the text is no JSON, is longer or deeper than its bounds, names a key
///         of an object twice, or holds a number that no double can: NaN and Infinity are no JSON, 1e999
///         overflows.
nlohmann::json parse_json(std::string_view text, const std::string& where, const JsonBounds& bounds = {});
nlohmann::ordered_json parse_ordered_json(std::string_view text, const std::string& where,
                                          const JsonBounds& bounds = {});

/// The JSON in a file. Throws: as parse_json, and InputError if the file cannot be read.
nlohmann::json read_json_file(const std::filesystem::path& path, const JsonBounds& bounds = {});

/// The bytes of a file. Throws: InputError if it cannot be read or has more than `most`.
std::string read_text_file(const std::filesystem::path& path, std::size_t most);

/// The number, or null if it is not finite.
inline nlohmann::json number_or_null(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json();
}

/// The value, or null if there is none.
template <typename T>
nlohmann::json or_null(const std::optional<T>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json();
}

}  // namespace palpate::reference

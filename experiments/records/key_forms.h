// What may stand under the keys of a record or a provenance that somebody else wrote.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "core/base/error.h"

namespace palpate::experiments {

/// The longest line of a record: an answer of 16 MiB may stand in it, and what the judge says of it.
inline constexpr std::size_t kLongestRecord = std::size_t{64} << 20U;

/// What may stand under a key, where it is there.
struct KeyForm {
  const char* key;
  const char* expected;
  bool (*fits)(const nlohmann::json& value);
};

inline bool is_text(const nlohmann::json& value) {
  return value.is_string();
}

inline constexpr const char* kCountForm = "a whole number from 0 to 1000000000";

inline bool is_count(const nlohmann::json& value) {
  constexpr std::int64_t kMost = 1'000'000'000;
  return value.is_number_integer() && value >= 0 && value <= kMost;
}

/// Throws: InputError, "`where`: key: expected ..., found ...", for the first key that has something else.
inline void check_keys(const nlohmann::json& object, std::span<const KeyForm> forms,
                       const std::string& where) {
  for (const KeyForm& form : forms) {
    const auto found = object.find(form.key);
    if (found == object.end() || form.fits(*found)) continue;
    const std::string kind = found->type_name();
    throw InputError(where + ": " + form.key, 0, form.expected,
                     found->is_number() ? found->dump()
                     : kind == "null"   ? kind
                                        : "another " + kind);
  }
}

}  // namespace palpate::experiments

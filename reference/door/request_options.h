// Options of a request, taken out one by one, so that what is left is what nobody knows.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/error.h"

namespace palpate::reference {

/// Removes `key` from `options` and returns its value as T, or `fallback` if it is absent. `is_type` is the
/// test of the JSON value that it must pass. Throws: InputError for another type.
template <typename T>
T take_option(nlohmann::json& options, const char* key, bool (nlohmann::json::*is_type)() const noexcept,
              const char* expected, T fallback) {
  const auto it = options.find(key);
  if (it == options.end()) return fallback;
  if (!((*it).*is_type)()) throw InputError(key, 0, expected, it->dump());
  T value = it->template get<T>();
  options.erase(it);
  return value;
}

/// Takes a number from `least` to `most` out of `options`. Throws: InputError for anything else.
double take_number(nlohmann::json& options, const char* key, double least, double most, double fallback);

/// The same for a whole number.
std::int64_t take_whole(nlohmann::json& options, const char* key, std::int64_t least, std::int64_t most,
                        std::int64_t fallback);

/// Takes a choice out of `options`: the position of its value in `choices`. Throws: InputError for any other.
std::size_t take_choice(nlohmann::json& options, const char* key, const std::vector<std::string>& choices);

/// Throws InputError naming the first option that nobody took.
void require_all_taken(const nlohmann::json& options);

}  // namespace palpate::reference

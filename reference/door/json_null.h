// JSON has no number for NaN, for an infinity or for what is missing: null stands for them.
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

namespace palpate::reference {

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

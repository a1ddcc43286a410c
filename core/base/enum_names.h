// The names by which people call the values of an enumeration.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/error.h"

namespace palpate {

/// A name for each of an enumeration's values, which count from 0; `what` stands for the value in messages.
template <typename Enum, std::size_t kCount>
struct EnumNames {
  const char* what;
  std::array<const char*, kCount> names;

  /// Throws: ContractError for a value without a name.
  const char* of(Enum value) const {
    const auto at = static_cast<std::size_t>(value);
    if (at >= kCount) throw ContractError(std::string(what) + ": a value without a name");
    return names[at];
  }

  /// The value of that name, or nothing.
  std::optional<Enum> find(std::string_view name) const {
    for (std::size_t at = 0; at < kCount; ++at) {
      if (name == names[at]) return static_cast<Enum>(at);
    }
    return std::nullopt;
  }

  /// All names for a message: "tet, face, edge or node".
  std::string known() const {
    std::string text;
    for (std::size_t at = 0; at < kCount; ++at)
      text += (at == 0 ? "" : (at + 1 < kCount ? ", " : " or ")) + std::string(names[at]);
    return text;
  }

  /// Throws: InputError that lists the names.
  Enum parse(std::string_view name) const {
    const std::optional<Enum> value = find(name);
    if (!value) throw InputError(what, 0, known(), std::string(name));
    return *value;
  }
};

}  // namespace palpate

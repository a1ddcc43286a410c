// An option as descriptions name it.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/base/enum_names.h"

namespace palpate::experiments {

/// kFile: the path of a file that is there, absolute once it is read; empty: none.
enum class OptionType { kChoice, kNumber, kInteger, kBool, kFile };
inline constexpr EnumNames<OptionType, 5> kOptionTypeNames{"an option's type",
                                                           {"choice", "number", "integer", "bool", "file"}};

/// One option of a method.
struct OptionSpec {
  std::string name;
  OptionType type = OptionType::kNumber;
  std::vector<std::string> choices;  ///< kChoice
  std::optional<double> min;         ///< kNumber and kInteger
  std::optional<double> max;
  nlohmann::json default_value;  ///< typed; null: left out unless it is given
  std::string help;
};

}  // namespace palpate::experiments

// An option as descriptions name it.
#pragma once

#include <algorithm>
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
  bool counts_ranks = false;  ///< kInteger: the number of MPI processes that the program starts itself as
};

/// The option that is the number of MPI processes (`ranks: true` in the description); null: it runs as one.
inline const OptionSpec* find_ranks_option(const std::vector<OptionSpec>& options) {
  const auto found = std::find_if(options.begin(), options.end(),
                                  [](const OptionSpec& option) { return option.counts_ranks; });
  return found == options.end() ? nullptr : &*found;
}

/// The MPI processes that a method with these options runs as, `chosen` typed as resolve_options leaves them;
/// 1 without such an option.
inline int count_ranks(const std::vector<OptionSpec>& options, const nlohmann::json& chosen) {
  const OptionSpec* ranks = find_ranks_option(options);
  return ranks == nullptr ? 1 : chosen.value(ranks->name, 1);
}

}  // namespace palpate::experiments

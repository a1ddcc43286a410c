// Figures of a record as people read them: "-" where there is none.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "core/base/number_text.h"

namespace palpate::experiments {

/// A share as "5.12%", of three digits.
inline std::string percent_text(double share) {
  return three_digits(100.0 * share) + "%";
}

/// The same of a number of a record; "-" where it is none.
inline std::string percent_of(const nlohmann::json& share) {
  return share.is_number() ? percent_text(share.get<double>()) : "-";
}

}  // namespace palpate::experiments

#include "reference/door/request_options.h"

#include <algorithm>

namespace palpate::reference {

using nlohmann::json;

double take_number(json& options, const char* key, double least, double most, double fallback) {
  const std::string expected = "a number from " + json(least).dump() + " to " + json(most).dump();
  const auto value = take_option<double>(options, key, &json::is_number, expected.c_str(), fallback);
  if (!(value >= least && value <= most)) throw InputError(key, 0, expected, json(value).dump());
  return value;
}

std::int64_t take_whole(json& options, const char* key, std::int64_t least, std::int64_t most,
                        std::int64_t fallback) {
  const std::string expected = "a whole number from " + std::to_string(least) + " to " + std::to_string(most);
  const auto value =
      take_option<std::int64_t>(options, key, &json::is_number_integer, expected.c_str(), fallback);
  if (value < least || value > most) throw InputError(key, 0, expected, std::to_string(value));
  return value;
}

std::size_t take_choice(json& options, const char* key, const std::vector<std::string>& choices) {
  const std::string value =
      take_option<std::string>(options, key, &json::is_string, "a name", choices.front());
  const auto it = std::find(choices.begin(), choices.end(), value);
  if (it != choices.end()) return static_cast<std::size_t>(it - choices.begin());
  std::string expected = "one of";
  for (const std::string& choice : choices) expected += " " + choice;
  throw InputError(key, 0, expected, value);
}

void require_all_taken(const json& options) {
  if (!options.empty()) throw InputError("options", 0, "known options", options.begin().key());
}

}  // namespace palpate::reference

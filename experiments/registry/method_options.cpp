#include "experiments/registry/method_options.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "core/base/error.h"
#include "experiments/text/nearest_name.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

std::string bounds_text(const OptionSpec& option) {
  std::ostringstream text;
  text << (option.type == OptionType::kInteger ? "a whole number" : "a number");
  if (option.min && option.max) {
    text << " from " << *option.min << " to " << *option.max;
  } else if (option.min) {
    text << ", at least " << *option.min;
  } else if (option.max) {
    text << ", at most " << *option.max;
  }
  return text.str();
}

template <typename T>
json parse_bounded(const OptionSpec& option, const std::string& text, const std::string& where) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = error == std::errc() && end == text.data() + text.size();
  const auto real = static_cast<double>(value);
  if (!whole || !std::isfinite(real) || (option.min && real < *option.min) ||
      (option.max && real > *option.max)) {
    throw InputError(where + ": " + option.name, 0, bounds_text(option), "\"" + text + "\"");
  }
  return value;
}

}  // namespace

json parse_option(const OptionSpec& option, const std::string& text, const std::string& where) {
  switch (option.type) {
    case OptionType::kChoice:
      if (std::find(option.choices.begin(), option.choices.end(), text) == option.choices.end()) {
        throw InputError(where + ": " + option.name, 0, "one of " + joined(option.choices),
                         "\"" + text + "\"" + nearest_hint(text, option.choices));
      }
      return text;
    case OptionType::kBool:
      if (text != "true" && text != "false") {
        throw InputError(where + ": " + option.name, 0, "true or false", "\"" + text + "\"");
      }
      return text == "true";
    case OptionType::kInteger:
      return parse_bounded<std::int64_t>(option, text, where);
    case OptionType::kNumber:
      return parse_bounded<double>(option, text, where);
    case OptionType::kFile: {
      std::error_code error;
      if (text.empty()) return text;
      if (!std::filesystem::is_regular_file(text, error))
        throw InputError(where + ": " + option.name, 0, "a file", "none at \"" + text + "\"");
      return std::filesystem::absolute(text).lexically_normal().string();
    }
  }
  throw ContractError("parse_option: unknown type");
}

json resolve_options(const MethodSpec& method, const std::map<std::string, GivenOption>& given) {
  json options = json::object();
  for (const OptionSpec& option : method.options) {
    if (!option.default_value.is_null()) options[option.name] = option.default_value;
  }
  for (const auto& [name, value] : given) {
    const OptionSpec* option = method.find_option(name);
    if (option == nullptr) {
      std::vector<std::string> names;
      for (const OptionSpec& spec : method.options) names.push_back(spec.name);
      throw InputError(value.where + ": " + method.name + " has no option \"" + name + "\"" +
                       nearest_hint(name, names));
    }
    options[name] = parse_option(*option, value.text, value.where);
  }
  return options;
}

}  // namespace palpate::experiments

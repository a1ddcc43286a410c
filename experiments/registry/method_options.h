// Options as plans and command lines give them: read as their types, and completed with the defaults.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "experiments/registry/contestant.h"

namespace palpate::experiments {

/// An option as it was given.
struct GivenOption {
  std::string text;
  std::string where;
};

/// Reads an option's value as its type from text, as in `--set name=value` and in YAML.
/// Throws: InputError that starts with `where` and names the choices or the bounds.
nlohmann::json parse_option(const OptionSpec& option, const std::string& text, const std::string& where);

/// Every option of the method, typed: `given` where it is given, the default (if not null) otherwise.
/// `given` maps a name to its text and to the place named in messages.
/// Throws: InputError for an unknown option (with the nearest) or a bad value.
nlohmann::json resolve_options(const MethodSpec& method, const std::map<std::string, GivenOption>& given);

}  // namespace palpate::experiments

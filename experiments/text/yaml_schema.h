// Which kind of file a YAML file says that it is.
#pragma once

#include <string>

#include "experiments/text/yaml_value.h"

namespace palpate::experiments {

/// Holds the key "schema" of a mapping against what is read, before any other key is looked at: a file of
/// another version may well have keys that this one does not know. What is no mapping is left to who reads
/// its keys.
///
/// Throws: InputError with file and line where the key is missing or names another schema; of a kind that
///         another command takes, with that command.
void require_schema(const YamlValue& root, const std::string& schema);

/// What the key "schema" of a mapping says; empty if there is none.
std::string find_schema(const YamlValue& root);

}  // namespace palpate::experiments

// YAML files read with suspicion: bounded, without anchors, every key asked for, every error with its line.
#pragma once

#include <yaml-cpp/yaml.h>

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace palpate::experiments {

class YamlFields;

/// A value in a YAML file that knows where it stands. Copies are cheap.
///
/// Each reader throws InputError "file:line: ..." when the value is of another kind.
class YamlValue {
 public:
  YamlValue(std::shared_ptr<const std::string> file, const YAML::Node& node, std::size_t line,
            std::string name)
      : file_(std::move(file)), node_(node), line_(line), name_(std::move(name)) {}

  bool is_text() const { return node_.IsScalar(); }
  bool is_list() const { return node_.IsSequence(); }
  bool is_map() const { return node_.IsMap(); }

  /// The mapping's values by key. Refuses keys that are not in `allowed` (with the nearest) and keys twice.
  YamlFields fields(const std::vector<std::string>& allowed) const;
  YamlFields fields(std::initializer_list<const char*> allowed) const;

  /// The mapping's values with any keys, in the file's order; keys twice are refused.
  std::vector<std::pair<std::string, YamlValue>> entries() const;

  std::vector<YamlValue> items() const;

  /// The list without the items that are this text.
  YamlValue without_text(const std::string& text) const;
  std::string text() const;
  double number() const;
  std::int64_t integer() const;
  bool boolean() const;

  /// number() and integer() inside [low, high].
  double number(double low, double high) const;
  std::int64_t integer(std::int64_t low, std::int64_t high) const;

  /// A name for people and files: letters, digits, '_', '-' and '.', at most 80 of them.
  std::string identifier() const;

  /// The value as JSON; true, false and numbers typed as in YAML 1.2, everything else text.
  nlohmann::json json() const;

  std::size_t line() const { return line_; }
  const std::string& file() const { return *file_; }
  const std::string& name() const { return name_; }

  /// Throws InputError "file:line: message".
  [[noreturn]] void fail(const std::string& message) const;

  /// Throws InputError "file:line: name: expected ..., found ...".
  [[noreturn]] void fail_expected(const std::string& expected) const;

 private:
  std::string shown() const;
  /// The word of a scalar that does not stand in quotes, which make a text of it; else nothing.
  std::string plain() const;

  std::shared_ptr<const std::string> file_;
  YAML::Node node_;
  std::size_t line_;
  std::string name_;
};

/// The checked keys of one mapping.
class YamlFields {
 public:
  YamlFields(YamlValue self, std::vector<std::pair<std::string, YamlValue>> entries)
      : self_(std::move(self)), entries_(std::move(entries)) {}

  std::optional<YamlValue> find(const std::string& key) const;

  /// The value of a key that has to be there. Throws InputError if it is not.
  YamlValue need(const std::string& key) const;

  const YamlValue& self() const { return self_; }

 private:
  YamlValue self_;
  std::vector<std::pair<std::string, YamlValue>> entries_;
};

/// Reads one YAML document. Bounds: 1 MiB, 32 levels, 100,000 values; anchors and aliases are refused, so
/// that a small file cannot stand for a large value. Nothing that the file says is run or looked up. Throws:
/// InputError with file and line.
YamlValue read_yaml(const std::filesystem::path& path);

/// As read_yaml, from memory; `where` stands for the file in messages.
YamlValue parse_yaml(const std::string& text, const std::string& where);

}  // namespace palpate::experiments

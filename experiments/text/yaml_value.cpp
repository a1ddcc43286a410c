#include "experiments/text/yaml_value.h"

#include <yaml-cpp/eventhandler.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/base/plain_file.h"
#include "experiments/text/nearest_name.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace {

constexpr std::size_t kLargestYaml = 1U << 20U;
constexpr int kDeepest = 32;
constexpr std::size_t kMostValues = 100'000;
constexpr std::size_t kMostKeys = 1000;  // of a mapping: they are compared with one another

std::size_t line_of(const YAML::Mark& mark) {
  return mark.is_null() ? 0 : static_cast<std::size_t>(mark.line) + 1;
}

[[noreturn]] void fail_at(const std::string& where, std::size_t line, const std::string& message) {
  throw InputError(where + (line > 0 ? ":" + std::to_string(line) : "") + ": " + message);
}

/// Walks a document without building it, and refuses what could make it large.
class Guard : public YAML::EventHandler {
 public:
  explicit Guard(const std::string& where) : where_(where) {}

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override { value(mark, anchor); }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override { refuse_anchor(mark); }
  void OnScalar(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                const std::string&) override {
    value(mark, anchor);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(mark, anchor);
  }
  void OnSequenceEnd() override { --depth_; }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(mark, anchor);
  }
  void OnMapEnd() override { --depth_; }

 private:
  [[noreturn]] void refuse_anchor(const YAML::Mark& mark) const {
    fail_at(where_, line_of(mark), "anchors and aliases (& and *) are not allowed here");
  }

  void value(const YAML::Mark& mark, YAML::anchor_t anchor) {
    if (anchor != 0) refuse_anchor(mark);
    if (++values_ > kMostValues) {
      fail_at(where_, line_of(mark), "more than " + std::to_string(kMostValues) + " values");
    }
  }

  void open(const YAML::Mark& mark, YAML::anchor_t anchor) {
    value(mark, anchor);
    if (++depth_ > kDeepest) {
      fail_at(where_, line_of(mark), "nested more than " + std::to_string(kDeepest) + " levels deep");
    }
  }

  std::string where_;
  int depth_ = 0;
  std::size_t values_ = 0;
};

void check_text(const std::string& text, const std::string& where) {
  if (text.size() > kLargestYaml) fail_at(where, 0, "larger than 1 MiB, the most that is read");
  const auto control = std::find_if(text.begin(), text.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte < 32 && c != '\n' && c != '\r' && c != '\t';
  });
  if (control != text.end()) {
    const auto line = static_cast<std::size_t>(std::count(text.begin(), control, '\n')) + 1;
    fail_at(where, line, "expected a text file in YAML, found a control character");
  }
}

template <typename T>
std::optional<T> parsed(const std::string& text) {
  T value{};
  const char* begin = text.data() + (text.size() > 1 && text[0] == '+' && text[1] != '-' ? 1 : 0);
  const auto [end, error] = std::from_chars(begin, text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

void YamlValue::fail(const std::string& message) const {
  fail_at(*file_, line_, message);
}

std::string YamlValue::shown() const {
  if (node_.IsSequence()) return "a list";
  if (node_.IsMap()) return "a mapping";
  if (!node_.IsScalar()) return "nothing";
  const std::string& text = node_.Scalar();
  const std::string shown = "\"" + (text.size() > 60 ? text.substr(0, 57) + "..." : text) + "\"";
  const bool is_number_or_flag = text == "true" || text == "false" || parsed<double>(text);
  return shown + (is_number_or_flag && node_.Tag() == "!" ? ", which is text as it stands in quotes" : "");
}

void YamlValue::fail_expected(const std::string& expected) const {
  fail((name_.empty() ? "" : name_ + ": ") + "expected " + expected + ", found " + shown());
}

std::vector<std::pair<std::string, YamlValue>> YamlValue::entries() const {
  if (!node_.IsMap()) fail_expected("a mapping (key: value)");
  std::vector<std::pair<std::string, YamlValue>> all;
  if (node_.size() > kMostKeys) fail_expected("at most " + std::to_string(kMostKeys) + " keys");
  for (const auto& entry : node_) {
    const std::size_t line = line_of(entry.first.Mark());
    if (!entry.first.IsScalar()) fail_at(*file_, line, "expected a word as a key");
    const std::string& key = entry.first.Scalar();
    for (const auto& [other, value] : all) {
      if (other == key) fail_at(*file_, line, "key \"" + key + "\" twice");
    }
    const std::size_t own = line_of(entry.second.Mark());
    all.emplace_back(key, YamlValue(file_, entry.second, own > 0 ? own : line, key));
  }
  return all;
}

YamlFields YamlValue::fields(std::initializer_list<const char*> allowed) const {
  return fields(std::vector<std::string>(allowed.begin(), allowed.end()));
}

YamlFields YamlValue::fields(const std::vector<std::string>& known) const {
  auto all = entries();
  std::size_t index = 0;
  for (const auto& entry : node_) {
    const std::string& key = all[index++].first;
    if (std::find(known.begin(), known.end(), key) == known.end()) {
      fail_at(*file_, line_of(entry.first.Mark()), "unknown key \"" + key + "\"" + nearest_hint(key, known));
    }
  }
  return {*this, std::move(all)};
}

std::vector<YamlValue> YamlValue::items() const {
  if (!node_.IsSequence()) fail_expected("a list");
  std::vector<YamlValue> all;
  for (const YAML::Node& item : node_) {
    const std::size_t own = line_of(item.Mark());
    all.emplace_back(file_, item, own > 0 ? own : line_, name_);
  }
  return all;
}

YamlValue YamlValue::without_text(const std::string& text) const {
  YAML::Node rest(YAML::NodeType::Sequence);
  for (const YAML::Node& item : node_) {
    if (!item.IsScalar() || item.Scalar() != text) rest.push_back(item);
  }
  return {file_, rest, line_, name_};
}

std::string YamlValue::text() const {
  if (!node_.IsScalar()) fail_expected("text");
  return node_.Scalar();
}

std::string YamlValue::plain() const {
  const bool is_quoted = node_.IsScalar() && node_.Tag() == "!";
  return node_.IsScalar() && !is_quoted ? node_.Scalar() : "";
}

double YamlValue::number() const {
  const auto value = parsed<double>(plain());
  if (!value || !std::isfinite(*value)) fail_expected("a number");
  return *value;
}

double YamlValue::number(double low, double high) const {
  const double value = number();
  if (value < low || value > high) {
    fail_expected("a number from " + short_number(low) + " to " + short_number(high));
  }
  return value;
}

std::int64_t YamlValue::integer() const {
  const auto value = parsed<std::int64_t>(plain());
  if (!value) fail_expected("a whole number");
  return *value;
}

std::int64_t YamlValue::integer(std::int64_t low, std::int64_t high) const {
  const std::int64_t value = integer();
  if (value < low || value > high) {
    fail_expected("a whole number from " + std::to_string(low) + " to " + std::to_string(high));
  }
  return value;
}

bool YamlValue::boolean() const {
  const std::string value = plain();
  if (value != "true" && value != "false") fail_expected("true or false");
  return value == "true";
}

std::string YamlValue::identifier() const {
  std::string value = text();
  const bool fits = !value.empty() && value.size() <= 80 && value.front() != '.' && value.front() != '-' &&
                    std::all_of(value.begin(), value.end(), [](char c) {
                      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                             c == '_' || c == '-' || c == '.';
                    });
  if (!fits) fail_expected("a name of letters, digits, '_', '-' and '.'");
  return value;
}

nlohmann::json YamlValue::json() const {
  nlohmann::json value;
  if (node_.IsMap()) {
    value = nlohmann::json::object();
    for (const auto& [key, entry] : entries()) value[key] = entry.json();
  } else if (node_.IsSequence()) {
    value = nlohmann::json::array();
    for (const YamlValue& item : items()) value.push_back(item.json());
  } else if (node_.IsScalar()) {
    const std::string& word = node_.Scalar();
    const bool quoted = node_.Tag() == "!";
    if (quoted) return word;
    if (word == "true" || word == "false") return word == "true";
    if (const auto whole = parsed<std::int64_t>(word)) return *whole;
    if (const auto real = parsed<double>(word); real && std::isfinite(*real)) return *real;
    value = word;
  }
  return value;
}

std::optional<YamlValue> YamlFields::find(const std::string& key) const {
  for (const auto& [name, value] : entries_) {
    if (name == key) return value;
  }
  return std::nullopt;
}

YamlValue YamlFields::need(const std::string& key) const {
  auto value = find(key);
  if (!value) self_.fail("the key \"" + key + "\" is missing");
  return *std::move(value);
}

YamlValue parse_yaml(const std::string& text, const std::string& where) {
  check_text(text, where);
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    Guard guard(where);
    if (!parser.HandleNextDocument(guard)) fail_at(where, 0, "the file is empty");
    if (parser.HandleNextDocument(guard)) fail_at(where, 0, "expected one YAML document, found more");
    const YAML::Node root = YAML::Load(text);
    if (!root.IsDefined() || root.IsNull()) fail_at(where, 0, "the file is empty");
    const std::size_t line = line_of(root.Mark());
    return {std::make_shared<const std::string>(where), root, line, ""};
  } catch (const YAML::Exception& error) {
    fail_at(where, line_of(error.mark), "not YAML: " + error.msg);
  }
}

YamlValue read_yaml(const std::filesystem::path& path) {
  const std::string where = path.string();
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) throw InputError(where, 0, "a YAML file", "no such file");
  refuse_no_file(path, "a YAML file");
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError(where, 0, "a YAML file that can be read", "no permission");
  std::string text(kLargestYaml + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  return parse_yaml(text, where);
}

}  // namespace palpate::experiments

#include "reference/door/json_file.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <set>
#include <vector>

#include "core/base/error.h"
#include "core/base/plain_file.h"

namespace palpate::reference {
namespace {

using nlohmann::json;

/// In lists and objects, all together: the shortest ones take thirty times as much memory as their text.
constexpr std::size_t kMostValues = std::size_t{1} << 25U;

/// From 1; 0 in a text of one line.
std::size_t line_of(std::string_view text, std::size_t place) {
  if (text.find('\n') == std::string_view::npos) return 0;
  const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min(place, text.size()));
  return 1 + static_cast<std::size_t>(std::count(text.begin(), end, '\n'));
}

bool is_word(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '+' || c == '-' || c == '.';
}

/// Looks at the text before it is parsed: the parser's own tree must never be deeper than the bound, and a
/// word like NaN gets a message that names it.
class Scan {
 public:
  Scan(std::string_view text, const std::string& where, std::size_t depth)
      : text_(text), where_(where), deepest_(depth) {}

  void run() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '"') {
        skip_string();
      } else if (c == '[' || c == '{' || c == ',') {
        if (++values_ > kMostValues)
          fail("at most " + std::to_string(kMostValues) + " values of JSON", "more");
        if (c != ',' && ++depth_ > deepest_)
          fail("at most " + std::to_string(deepest_) + " levels of nesting", "more");
        ++at_;
      } else if (c == ']' || c == '}') {
        if (depth_ > 0) --depth_;
        ++at_;
      } else if (is_word(c)) {
        check_word();
      } else {
        ++at_;
      }
    }
  }

 private:
  [[noreturn]] void fail(const std::string& expected, const std::string& found) const {
    throw InputError(where_, line_of(text_, at_), expected, found);
  }

  void skip_string() {
    for (++at_; at_ < text_.size() && text_[at_] != '"'; ++at_) {
      if (text_[at_] == '\\') ++at_;
    }
    ++at_;
  }

  void check_word() {
    const std::size_t start = at_;
    std::size_t end = at_;
    while (end < text_.size() && is_word(text_[end])) ++end;
    const std::string word(text_.substr(start, std::min<std::size_t>(end - start, 40)));
    std::string plain = word;
    for (char& c : plain) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    plain.erase(0, plain.find_first_not_of("+-"));
    if (plain == "nan" || plain == "inf" || plain == "infinity") fail("a number", word);
    at_ = end;
  }

  std::string_view text_;
  const std::string& where_;
  std::size_t deepest_;
  std::size_t depth_ = 0;
  std::size_t values_ = 0;
  std::size_t at_ = 0;
};

/// Refuses an object that names a key twice: the last one would win without a word.
class KeysOnce {
 public:
  template <typename Json>
  bool operator()(json::parse_event_t event, const Json& parsed) {
    if (event == json::parse_event_t::object_start) keys_.emplace_back();
    if (event == json::parse_event_t::object_end) keys_.pop_back();
    if (event == json::parse_event_t::key) {
      const auto name = parsed.template get<std::string>();
      if (!keys_.back().insert(name).second) twice_ = twice_.empty() ? name : twice_;
    }
    return true;
  }
  const std::string& twice() const { return twice_; }

 private:
  std::vector<std::set<std::string>> keys_;
  std::string twice_;
};

template <typename Json>
Json parse(std::string_view text, const std::string& where, const JsonBounds& bounds) {
  if (text.size() > bounds.bytes)
    throw InputError(where, 0, "at most " + std::to_string(bounds.bytes) + " bytes of JSON",
                     std::to_string(text.size()));
  Scan(text, where, bounds.depth).run();
  KeysOnce keys;
  const auto watch = [&keys](int, typename Json::parse_event_t event, Json& parsed) {
    return keys(event, parsed);
  };
  try {
    Json value = Json::parse(text.begin(), text.end(), watch);
    if (!keys.twice().empty()) throw InputError(where + ": the key \"" + keys.twice() + "\" stands twice");
    return value;
  } catch (const typename Json::parse_error& error) {
    throw InputError(where, line_of(text, error.byte), "JSON",
                     "none from byte " + std::to_string(error.byte));
  } catch (const typename Json::out_of_range& error) {
    const std::string what = error.what();  // "... number overflow parsing '1e999'"
    const std::size_t quote = what.find('\'');
    throw InputError(where, 0, "numbers that fit into a double",
                     quote == std::string::npos ? what : what.substr(quote));
  }
}

}  // namespace

json parse_json(std::string_view text, const std::string& where, const JsonBounds& bounds) {
  return parse<json>(text, where, bounds);
}

nlohmann::ordered_json parse_ordered_json(std::string_view text, const std::string& where,
                                          const JsonBounds& bounds) {
  return parse<nlohmann::ordered_json>(text, where, bounds);
}

std::string read_text_file(const std::filesystem::path& path, std::size_t most) {
  refuse_no_file(path, "a readable file");
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    throw InputError(path.string(), 0, "a readable file", "none");
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  std::ifstream file(path, std::ios::binary);
  if (error || !file) throw InputError(path.string(), 0, "a readable file", "none");
  if (size > most)
    throw InputError(path.string(), 0, "at most " + std::to_string(most) + " bytes", std::to_string(size));
  std::string text(static_cast<std::size_t>(size), '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(std::max<std::streamsize>(0, file.gcount())));
  return text;
}

json read_json_file(const std::filesystem::path& path, const JsonBounds& bounds) {
  return parse_json(read_text_file(path, bounds.bytes), path.string(), bounds);
}

}  // namespace palpate::reference

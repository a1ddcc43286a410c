// Files of numbers: lines of text up to one that says "end", then arrays, little-endian.
#pragma once

#include <bit>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <map>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/base/error.h"

namespace palpate::reference {

static_assert(std::endian::native == std::endian::little, "the files are little-endian");

/// Appends the bytes of an array.
template <typename Item>
void append_numbers(std::string& out, const std::vector<Item>& items) {
  const std::size_t at = out.size();
  out.resize(at + items.size() * sizeof(Item));
  if (!items.empty()) std::memcpy(out.data() + at, items.data(), items.size() * sizeof(Item));
}

/// Takes arrays out of the bytes after the header, each bounded by what is left. Throws: InputError.
class NumbersAfter {
 public:
  NumbersAfter(const std::string& text, std::size_t at, std::string where)
      : text_(text), at_(at), where_(std::move(where)) {}

  template <typename Item>
  std::vector<Item> take(std::size_t count) {
    if (count > (text_.size() - at_) / sizeof(Item))
      throw InputError(where_, 0, std::to_string(count) + " numbers more", "the end of the file");
    std::vector<Item> items(count);
    if (count > 0) std::memcpy(items.data(), text_.data() + at_, count * sizeof(Item));
    at_ += count * sizeof(Item);
    return items;
  }

  template <typename Number>
  std::vector<Number> take_finite(std::size_t count) {
    std::vector<Number> numbers = take<Number>(count);
    for (const Number number : numbers) {
      if (!std::isfinite(number)) throw InputError(where_, 0, "finite numbers", "one that is not");
    }
    return numbers;
  }

  void require_end() const {
    if (at_ != text_.size())
      throw InputError(where_, 0, "the end of the file", std::to_string(text_.size() - at_) + " bytes more");
  }

 private:
  const std::string& text_;
  std::size_t at_;
  std::string where_;
};

/// The lines "key value" between the schema's and "end". Throws: InputError for another schema, a key twice,
/// a missing key, or a number out of its bounds.
class NumbersHeader {
 public:
  NumbersHeader(const std::string& text, const std::string& schema, std::string where)
      : where_(std::move(where)) {
    constexpr std::size_t kMostLines = 40;
    std::size_t at = 0;
    for (std::size_t line = 1; line <= kMostLines; ++line) {
      const std::size_t end = text.find('\n', at);
      if (end == std::string::npos || end - at > 200) break;
      const std::string words = text.substr(at, end - at);
      at = end + 1;
      if (line == 1) {
        if (words != schema) break;
      } else if (words == "end") {
        size_ = at;
        return;
      } else {
        const std::size_t space = words.find(' ');
        if (space == std::string::npos) break;
        if (!values_.insert({words.substr(0, space), words.substr(space + 1)}).second) break;
      }
    }
    throw InputError(where_, 0, "a file of " + schema, "something else");
  }

  template <typename Number>
  Number number(const char* key, Number least, Number most) const {
    const std::string found = word(key);
    Number value{};
    const auto [end, error] = std::from_chars(found.data(), found.data() + found.size(), value);
    if (error != std::errc() || end != found.data() + found.size() || !(value >= least && value <= most))
      throw InputError(where_, 0, std::string(key) + ": a number within its bounds", found);
    return value;
  }

  bool has(const char* key) const { return values_.count(key) != 0; }

  std::string word(const char* key) const {
    const auto at = values_.find(key);
    if (at == values_.end()) throw InputError(where_, 0, std::string("the key ") + key, "none");
    return at->second;
  }

  std::size_t size() const { return size_; }

 private:
  std::string where_;
  std::map<std::string, std::string> values_;
  std::size_t size_ = 0;
};

}  // namespace palpate::reference

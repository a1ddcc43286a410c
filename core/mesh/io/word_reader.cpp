#include "core/mesh/io/word_reader.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "core/base/error.h"

namespace palpate {
namespace {

constexpr std::size_t kBufferSize = 1U << 20U;
constexpr std::size_t kLongestWord = 256;

enum Kind : std::uint8_t { kText, kSpace, kNul };

constexpr std::array<Kind, 256> build_kinds() {
  std::array<Kind, 256> kinds{};
  for (const unsigned char c : {' ', '\n', '\t', '\r', '\f', '\v'}) kinds[c] = kSpace;
  kinds[0] = kNul;
  return kinds;
}

constexpr std::array<Kind, 256> kKinds = build_kinds();

Kind kind_of(char c) {
  return kKinds[static_cast<unsigned char>(c)];
}

}  // namespace

WordReader::WordReader(const std::filesystem::path& path) : name_(path.string()) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) throw InputError(name_, 0, "a mesh file", "no such file");
  if (std::filesystem::is_directory(path, error)) throw InputError(name_, 0, "a mesh file", "a folder");
  file_.reset(std::fopen(path.c_str(), "rb"));
  if (!file_) throw InputError(name_, 0, "a readable file", std::strerror(errno));
  if (std::filesystem::is_regular_file(path, error)) {
    size_ = std::filesystem::file_size(path, error);
    has_size_ = !error;
  }
  buffer_.resize(kBufferSize + 1);
  if (!refill()) throw InputError(name_, 0, "a MEDIT mesh", "an empty file");
}

std::string_view WordReader::next() {
  const bool found = skip_space();
  word_line_ = line_;
  if (!found) return {};
  // Look far enough ahead that no word crosses the end of the buffer.
  if (end_ - at_ <= kLongestWord) refill();
  const char* first = buffer_.data() + at_;
  const char* last = first;
  while (kind_of(*last) == kText) ++last;
  const auto size = static_cast<std::size_t>(last - first);
  if (size == 0 || size > kLongestWord) fail("text", "binary data");
  at_ += size;
  return {first, size};
}

void WordReader::fail(const std::string& expected, const std::string& found) const {
  throw InputError(name_, word_line_, expected, found);
}

std::uint64_t WordReader::bytes_left() const {
  const std::uint64_t read = consumed_ + at_;
  return size_ > read ? size_ - read : 0;
}

/// Goes on to the next byte that is neither white space nor comment; false at the end of the file.
bool WordReader::skip_space() {
  bool in_comment = false;
  while (true) {
    const char* at = buffer_.data() + at_;
    if (in_comment) {
      while (*at != '\n' && *at != '\0') ++at;
    } else {
      for (; kind_of(*at) == kSpace; ++at) line_ += *at == '\n' ? 1 : 0;
    }
    at_ = static_cast<std::size_t>(at - buffer_.data());
    if (at_ == end_) {
      if (!refill()) return false;
    } else if (*at == '#') {
      in_comment = true;
    } else if (in_comment && *at == '\n') {
      in_comment = false;
    } else {
      return true;
    }
  }
}

/// Moves the bytes that no word has taken to the front and reads on behind them; false if there was no more.
bool WordReader::refill() {
  if (at_file_end_) return false;
  const std::size_t kept = end_ - at_;
  std::memmove(buffer_.data(), buffer_.data() + at_, kept);
  consumed_ += at_;
  at_ = 0;
  const std::size_t got = std::fread(buffer_.data() + kept, 1, kBufferSize - kept, file_.get());
  end_ = kept + got;
  buffer_[end_] = '\0';
  at_file_end_ = end_ < kBufferSize;
  if (std::ferror(file_.get()) != 0) throw InputError(name_, 0, "a readable file", std::strerror(errno));
  return got > 0;
}

}  // namespace palpate

// Words of a text file, fast and with their line.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace palpate {

/// Reads white-space separated words through a buffer of fixed size. A word that starts with # begins a
/// comment that ends with its line. Throws: InputError from the constructor for a missing, unreadable or
/// empty file; from next() for binary data
///         and for an error while reading.
class WordReader {
 public:
  explicit WordReader(const std::filesystem::path& path);

  /// The next word, empty at the end of the file; valid until the next call.
  std::string_view next();

  /// Throws InputError that names the file and the line of the last word.
  [[noreturn]] void fail(const std::string& expected, const std::string& found) const;

  const std::string& name() const { return name_; }

  /// Whether the size of the file is known beforehand: not so for a pipe.
  bool has_size() const { return has_size_; }

  /// Bytes behind the last word. Requires has_size().
  std::uint64_t bytes_left() const;

 private:
  bool skip_space();
  bool refill();

  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  std::string name_;
  std::unique_ptr<std::FILE, Closer> file_;
  std::vector<char> buffer_;    ///< a NUL follows the bytes that were read
  std::size_t at_ = 0;          ///< first byte that no word has taken
  std::size_t end_ = 0;         ///< end of the bytes that were read
  std::uint64_t consumed_ = 0;  ///< bytes of the file before the buffer
  std::uint64_t size_ = 0;
  bool has_size_ = false;
  bool at_file_end_ = false;
  std::size_t line_ = 1;
  std::size_t word_line_ = 1;
};

}  // namespace palpate

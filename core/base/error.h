// The two kinds of failure that are thrown. A numerical outcome is neither: it is data in a report.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

namespace palpate {

/// Bad input: a file, a plan, a flag or an adapter's answer is not what it has to be.
///
/// The message is one line: where ("kidney.mesh:17"), what was expected, what was found. Exit code 2.
class InputError : public std::runtime_error {
 public:
  /// An error that needs no place.
  explicit InputError(const std::string& message) : std::runtime_error(message) {}

  /// `where` is a file, a flag or a key; `line` counts from 1, 0 when no line applies.
  InputError(const std::string& where, std::size_t line, const std::string& expected,
             const std::string& found)
      : std::runtime_error(format(where, line, expected, found)) {}

 private:
  static std::string format(const std::string& where, std::size_t line, const std::string& expected,
                            const std::string& found) {
    std::string text = where;
    if (line > 0) text += ":" + std::to_string(line);
    return text + ": expected " + expected + ", found " + found;
  }
};

/// A fault of our own: a function was called outside its contract. Thrown in every build. Exit code 3.
class ContractError : public std::logic_error {
 public:
  explicit ContractError(const std::string& message) : std::logic_error(message) {}
};

/// Something needed could not run: a program is missing, crashed or timed out. Exit code 3.
class UnavailableError : public std::runtime_error {
 public:
  explicit UnavailableError(const std::string& message) : std::runtime_error(message) {}
};

/// Throws ContractError with `message` unless `condition` holds.
inline void require(bool condition, const char* message) {
  if (!condition) throw ContractError(message);
}

}  // namespace palpate

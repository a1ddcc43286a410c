// The files that a contestant is given: it may read them, and must leave them as they are.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace palpate::experiments {

/// Input files as they are before a contestant runs. Contestants share them: one that overwrites its input
/// would change what the next one is asked.
class InputGuard {
 public:
  /// Files of up to so many bytes are kept in memory; of larger ones the hash is.
  explicit InputGuard(std::uint64_t most_kept = std::uint64_t{1} << 30U) : most_kept_(most_kept) {}

  /// Watches a file; nothing happens if there is none. Throws: InputError if it cannot be read.
  void watch(const std::filesystem::path& file);

  /// Puts a copy that cannot be written by its mode below `folder`, under the same name, and watches both.
  /// Returns its path; of a file that is not there its own, for the contestant to refuse it. Throws:
  /// InputError if `file` cannot be read or the copy not be written.
  std::filesystem::path copy(const std::filesystem::path& file, const std::filesystem::path& folder);

  /// Looks at every file again and puts back what has changed. Returns the names of those that had, each
  /// once. A file that is not kept in memory is put back from its copy, if that is as it was. Throws:
  /// InputError if a file cannot be put back.
  std::vector<std::string> restore() const;

 private:
  struct Watched {
    std::filesystem::path file;
    std::uint64_t size = 0;
    std::optional<std::string> bytes;  ///< unless it is too large to be kept
    std::string hash;                  ///< of one that is
    bool is_copy = false;              ///< nobody else reads it: it need not be put back

    bool is_as_it_was() const;
  };

  void put_back(const Watched& watched) const;

  std::uint64_t most_kept_;
  std::vector<Watched> watched_;
};

}  // namespace palpate::experiments

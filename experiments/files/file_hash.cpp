#include "experiments/files/file_hash.h"

#include <array>
#include <fstream>
#include <memory>
#include <vector>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "core/base/error.h"
#include "core/base/plain_file.h"
#include "experiments/files/plain_file.h"

namespace palpate::experiments {
namespace {

std::string hexadecimal(XXH128_hash_t hash) {
  static constexpr std::string_view kDigits = "0123456789abcdef";
  XXH128_canonical_t canonical;
  XXH128_canonicalFromHash(&canonical, hash);
  std::string text = "xxh3:";
  for (const unsigned char byte : canonical.digest) {
    text += kDigits[byte >> 4U];
    text += kDigits[byte & 15U];
  }
  return text;
}

/// Throws: InputError.
[[noreturn]] void refuse_size(const std::filesystem::path& path) {
  throw InputError(path.string(), 0, "a file of at most " + std::to_string(kLargestFile) + " bytes", "more");
}

}  // namespace

std::string hash_bytes(std::string_view bytes) {
  return hexadecimal(XXH3_128bits(bytes.data(), bytes.size()));
}

std::string hash_file(const std::filesystem::path& path) {
  refuse_no_file(path, "a file that can be read");
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError(path.string(), 0, "a file that can be read", "none");
  std::error_code error;
  if (const std::uintmax_t size = std::filesystem::file_size(path, error); !error && size > kLargestFile)
    refuse_size(path);
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(), &XXH3_freeState);
  require(state != nullptr, "hash_file: no memory");
  XXH3_128bits_reset(state.get());
  std::vector<char> block(1U << 18U);
  std::uint64_t bytes = 0;
  while (file) {
    file.read(block.data(), static_cast<std::streamsize>(block.size()));
    XXH3_128bits_update(state.get(), block.data(), static_cast<std::size_t>(file.gcount()));
    bytes += static_cast<std::uint64_t>(file.gcount());
    if (bytes > kLargestFile) refuse_size(path);
  }
  if (file.bad()) throw InputError(path.string(), 0, "a file that can be read", "a read error");
  return hexadecimal(XXH3_128bits_digest(state.get()));
}

}  // namespace palpate::experiments

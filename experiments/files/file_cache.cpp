#include "experiments/files/file_cache.h"

#include <cstdlib>

#include "core/base/error.h"
#include "experiments/files/file_hash.h"
#include "experiments/files/places.h"
#include "reference/door/json_file.h"

namespace palpate::experiments {

std::filesystem::path cache_root() {
  const char* moved = std::getenv("PALPATE_CACHE");
  if (moved != nullptr && *moved != '\0') return std::filesystem::absolute(moved);
  return default_cache_root();
}

std::filesystem::path cache_entry(const std::string& kind, const std::string& key) {
  const std::string hash = hash_bytes(key);
  return cache_root() / kind / hash.substr(hash.find(':') + 1);
}

nlohmann::json read_kept(const std::filesystem::path& path) {
  try {
    return reference::read_json_file(path);
  } catch (const InputError&) {  // not there, or damaged in whatever way: made again
    return {};
  }
}

}  // namespace palpate::experiments

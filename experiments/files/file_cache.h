// What is kept below the build folder (or in the user's cache), so that it is made once: meshes, answers,
// trained springs, data of organs.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace palpate::experiments {

/// The folder of the caches: PALPATE_CACHE if set, else default_cache_root(). Throws: InputError if an
/// installed program has none.
std::filesystem::path cache_root();

/// The folder of an entry, by the hash of its key: cache_root()/kind/0123...
std::filesystem::path cache_entry(const std::string& kind, const std::string& key);

/// The JSON of a cache's entry; null if there is none, or none that can be read.
nlohmann::json read_kept(const std::filesystem::path& path);

}  // namespace palpate::experiments

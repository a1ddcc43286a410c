// Finished made meshes, kept below the build folder.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "experiments/mesh_source.h"

namespace palpate::experiments {

/// The folder of the caches: PALPATE_CACHE if set, else the build folder.
std::filesystem::path cache_root();

/// Returns the mesh kept under `key`, or makes it and keeps it.
///
/// The key is joined with the bytes of the mesh programs, so that a new program makes a new mesh. An entry
/// carries the key and a checksum; one that disagrees is made again. A cache that cannot be written is no
/// failure: a note says so.
MadeMesh make_cached(const std::string& key, const std::function<MadeMesh()>& make);

}  // namespace palpate::experiments

// Finished made meshes, kept below the build folder.
#pragma once

#include <functional>
#include <string>

#include "experiments/meshes/shape_request.h"

namespace palpate::experiments {

/// Returns the mesh kept under `key`, or makes it and keeps it.
///
/// The key is joined with hashes of the mesh programs and of our own sources that make meshes, with the
/// compiler and its flags and the vendors' versions, so that whatever could make another mesh makes one. An
/// entry carries the key and a checksum; one that disagrees is made again. A cache that cannot be written is
/// no failure: a note says so.
MadeMesh make_cached(const std::string& key, const std::function<MadeMesh()>& make);

}  // namespace palpate::experiments

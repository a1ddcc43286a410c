// The option "sizes" of palpate.refined and palpate.surface: a file with the edge length wanted at each
// vertex.
#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "core/simplify/sizing/size_file.h"
#include "core/simplify/sizing/size_grid.h"
#include "reference/door/request_options.h"

namespace palpate::reference {

/// Takes the option: the file's path, empty if there is none. Throws: InputError for another type.
inline std::filesystem::path take_sizes_file(nlohmann::json& options) {
  return take_option<std::string>(options, "sizes", &nlohmann::json::is_string, "a file's path", "");
}

/// The sizes of a file for a mesh; nothing without a file, or where all are equal. Throws: InputError.
inline std::shared_ptr<const simplify::SizeGrid> load_sizes(const std::filesystem::path& file,
                                                            const TetMesh& mesh) {
  if (file.empty()) return nullptr;
  return simplify::make_size_grid(mesh, simplify::read_sizes(file, mesh.points.size()));
}

}  // namespace palpate::reference

#include "experiments/meshes/mesh_cache.h"

#include <exception>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/mesh/io/medit.h"
#include "experiments/files/file_cache.h"
#include "experiments/files/file_hash.h"
#include "experiments/meshes/mesh_tools.h"
#include "mesh_makers.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

constexpr const char* kSchema = "palpate/mesh_cache/1";

std::string full_key(const std::string& key) {
  std::string text = key + "; palpate " + PALPATE_VERSION + " " + PALPATE_MESH_MAKERS + "; " + __VERSION__ +
                     " " + PALPATE_FLAGS + "; " + PALPATE_VENDOR_VERSIONS;
  for (const MeshTool& tool : {kGmshTool, kSurfaceTool, kVtkTool}) {
    std::error_code error;
    const bool is_there = std::filesystem::is_regular_file(tool_path(tool), error);
    text += std::string("; ") + tool.program + " " + (is_there ? hash_file(tool_path(tool)) : "none");
  }
  return text;
}

std::optional<MadeMesh> load(const std::filesystem::path& mesh_path, const std::filesystem::path& info_path,
                             const std::string& key) {
  std::error_code error;
  if (!std::filesystem::exists(mesh_path, error) || !std::filesystem::exists(info_path, error)) return {};
  try {
    const json info = read_kept(info_path);
    if (!info.is_object() || info.at("schema") != kSchema || info.at("key") != key) return {};
    if (info.at("checksum") != hash_file(mesh_path)) return {};
    return MadeMesh{read_medit(mesh_path, ReadOrientation::kKeep).mesh,
                    info.at("notes").get<std::vector<std::string>>()};
  } catch (const std::exception&) {  // damaged in whatever way: made again
    return {};
  }
}

}  // namespace

MadeMesh make_cached(const std::string& key, const std::function<MadeMesh()>& make) {
  const std::string whole_key = full_key(key);
  const std::filesystem::path folder = cache_entry("mesh_cache", whole_key);
  const std::filesystem::path mesh_path = folder / "made.mesh";
  const std::filesystem::path info_path = folder / "made.json";
  if (auto kept = load(mesh_path, info_path, whole_key)) return *kept;
  MadeMesh made = make();
  try {
    std::filesystem::create_directories(folder);
    write_medit(mesh_path, made.mesh);
    const json info{
        {"schema", kSchema}, {"key", whole_key}, {"checksum", hash_file(mesh_path)}, {"notes", made.notes}};
    write_file_atomically(info_path, info.dump(2) + "\n");
  } catch (const InputError& error) {
    made.notes.push_back(std::string("the mesh was not kept in the cache: ") + error.what());
  } catch (const std::filesystem::filesystem_error& error) {
    made.notes.push_back(std::string("the mesh was not kept in the cache: ") + error.what());
  }
  return made;
}

}  // namespace palpate::experiments

#include "experiments/mesh_cache.h"

#include <array>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "experiments/mesh_tools.h"
#include "experiments/places.h"
#include "mesh_makers.h"
#include "reference/json_file.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

constexpr const char* kSchema = "palpate/mesh_cache/1";

/// FNV-1a, 64 bits: guards against damage and mix-ups, not against forgery.
std::string hash_of(std::string_view bytes) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (const char c : bytes) {
    hash ^= static_cast<unsigned char>(c);
    hash *= 0x100000001b3ULL;
  }
  std::array<char, 17> text{};
  std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(hash));
  return text.data();
}

std::string read_bytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::string full_key(const std::string& key) {
  std::string text = key + "; palpate " + PALPATE_VERSION + " " + PALPATE_MESH_MAKERS + "; " + __VERSION__ +
                     " " + PALPATE_FLAGS + "; " + PALPATE_VENDOR_VERSIONS;
  for (const MeshTool& tool : {kGmshTool, kSurfaceTool, kVtkTool}) {
    text += std::string("; ") + tool.program + " " + hash_of(read_bytes(tool_path(tool)));
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
    if (info.at("checksum") != hash_of(read_bytes(mesh_path))) return {};
    return MadeMesh{read_medit(mesh_path, ReadOrientation::kKeep).mesh,
                    info.at("notes").get<std::vector<std::string>>()};
  } catch (const std::exception&) {  // damaged in whatever way: made again
    return {};
  }
}

}  // namespace

json read_kept(const std::filesystem::path& path) {
  try {
    return reference::read_json_file(path);
  } catch (const InputError&) {  // not there, or damaged in whatever way: made again
    return {};
  }
}

std::filesystem::path cache_root() {
  const char* moved = std::getenv("PALPATE_CACHE");
  if (moved != nullptr && *moved != '\0') return std::filesystem::absolute(moved);
  return std::filesystem::path(program_folder()).parent_path();
}

MadeMesh make_cached(const std::string& key, const std::function<MadeMesh()>& make) {
  const std::string whole_key = full_key(key);
  const std::filesystem::path folder = cache_root() / "mesh_cache";
  const std::string name = hash_of(whole_key);
  const std::filesystem::path mesh_path = folder / (name + ".mesh");
  const std::filesystem::path info_path = folder / (name + ".json");
  if (auto kept = load(mesh_path, info_path, whole_key)) return *kept;
  MadeMesh made = make();
  try {
    std::filesystem::create_directories(folder);
    write_medit(mesh_path, made.mesh);
    const json info{{"schema", kSchema},
                    {"key", whole_key},
                    {"checksum", hash_of(read_bytes(mesh_path))},
                    {"notes", made.notes}};
    write_file_atomically(info_path, info.dump(2) + "\n");
  } catch (const InputError& error) {
    made.notes.push_back(std::string("the mesh was not kept in the cache: ") + error.what());
  } catch (const std::filesystem::filesystem_error& error) {
    made.notes.push_back(std::string("the mesh was not kept in the cache: ") + error.what());
  }
  return made;
}

}  // namespace palpate::experiments

#include "experiments/registry/registry.h"

#include <algorithm>
#include <cstdlib>
#include <set>
#include <sstream>

#include "core/base/error.h"
#include "experiments/files/places.h"
#include "experiments/registry/description.h"

namespace palpate::experiments {
namespace {

/// Descriptions directly in `root` or one folder below it.
std::vector<std::filesystem::path> find_descriptions(const std::filesystem::path& root) {
  std::vector<std::filesystem::path> found;
  std::error_code error;
  if (std::filesystem::exists(root / "contestant.yaml", error)) found.push_back(root / "contestant.yaml");
  for (const auto& entry : std::filesystem::directory_iterator(root, error)) {
    const auto description = entry.path() / "contestant.yaml";
    if (std::filesystem::exists(description, error)) found.push_back(description);
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace

Registry::Registry(std::vector<Contestant> contestants) : contestants_(std::move(contestants)) {
  std::stable_sort(contestants_.begin(), contestants_.end(),
                   [](const Contestant& a, const Contestant& b) { return a.folder < b.folder; });
  std::set<std::string> seen;
  for (const std::string& name : method_names()) {
    if (!seen.insert(name).second) throw InputError("method " + name + " is offered by two contestants");
  }
}

std::vector<std::string> Registry::method_names() const {
  std::vector<std::string> names;
  for (const Contestant& contestant : contestants_) {
    for (const MethodSpec& method : contestant.methods) names.push_back(method.name);
  }
  return names;
}

std::optional<MethodEntry> Registry::find(const std::string& method) const {
  for (const Contestant& contestant : contestants_) {
    for (const MethodSpec& spec : contestant.methods) {
      if (spec.name == method) return MethodEntry{&contestant, &spec};
    }
  }
  return std::nullopt;
}

Registry load_registry(const std::vector<std::filesystem::path>& more) {
  std::vector<std::filesystem::path> roots{std::filesystem::path(source_folder()) / "reference"};
  if (const char* extra = std::getenv("PALPATE_CONTESTANTS")) {
    std::istringstream list(extra);
    std::string folder;
    while (std::getline(list, folder, ':')) {
      if (folder.empty()) continue;
      if (!std::filesystem::is_directory(folder))
        throw InputError("PALPATE_CONTESTANTS", 0, "folders of contestants", "no folder " + folder);
      roots.emplace_back(folder);
    }
  }
  roots.insert(roots.end(), more.begin(), more.end());
  std::vector<Contestant> contestants;
  std::set<std::filesystem::path> seen;
  for (const auto& root : roots) {
    for (const auto& description : find_descriptions(root)) {
      if (!seen.insert(std::filesystem::weakly_canonical(description)).second) continue;
      for (Contestant& each : read_description(description, program_folder()))
        contestants.push_back(std::move(each));
    }
  }
  return Registry(std::move(contestants));
}

}  // namespace palpate::experiments

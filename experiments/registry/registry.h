// Which contestants there are, and who offers a method.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "experiments/registry/contestant.h"

namespace palpate::experiments {

/// All contestants that were found, sorted by folder.
class Registry {
 public:
  explicit Registry(std::vector<Contestant> contestants);

  const std::vector<Contestant>& contestants() const { return contestants_; }
  std::vector<std::string> method_names() const;

  /// The method of that name, or nothing.
  std::optional<MethodEntry> find(const std::string& method) const;

 private:
  std::vector<Contestant> contestants_;
};

/// Reads every description below reference/, below the folders that the environment variable
/// PALPATE_CONTESTANTS adds (separated by colons) and below those in `more`: each is the folder of a
/// contestant, or holds one folder a contestant. One that is found twice counts once.
/// Throws: InputError, also if two contestants offer a method of the same name.
Registry load_registry(const std::vector<std::filesystem::path>& more = {});

}  // namespace palpate::experiments

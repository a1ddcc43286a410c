#include "experiments/files/scratch_folder.h"

#include <cstdlib>
#include <system_error>

#include "core/base/error.h"

namespace palpate::experiments {

ScratchFolder::ScratchFolder() {
  std::error_code error;
  const std::filesystem::path base = std::filesystem::temp_directory_path(error);
  std::string pattern = ((error ? std::filesystem::path("/tmp") : base) / "palpate-XXXXXX").string();
  if (::mkdtemp(pattern.data()) == nullptr) throw UnavailableError("cannot make a scratch folder " + pattern);
  path_ = pattern;
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace palpate::experiments

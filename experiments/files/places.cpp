#include "experiments/files/places.h"

#include "experiments/files/installation.h"

namespace palpate::experiments {

const std::string& source_folder() {
  static const std::string folder =
      install_prefix() ? (*install_prefix() / "share" / "palpate").string() : PALPATE_SOURCE_DIR;
  return folder;
}

const std::string& program_folder() {
  static const std::string folder =
      install_prefix() ? (*install_prefix() / "lib" / "palpate").string() : PALPATE_BIN_DIR;
  return folder;
}

}  // namespace palpate::experiments

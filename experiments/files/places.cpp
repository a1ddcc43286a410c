#include "experiments/files/places.h"

namespace palpate::experiments {

const std::string& source_folder() {
  static const std::string folder = PALPATE_SOURCE_DIR;
  return folder;
}

const std::string& program_folder() {
  static const std::string folder = PALPATE_BIN_DIR;
  return folder;
}

}  // namespace palpate::experiments

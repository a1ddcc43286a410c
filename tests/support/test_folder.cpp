#include "tests/support/test_folder.h"

#include "experiments/files/places.h"

namespace palpate::test {

std::string test_folder() {
  return experiments::source_folder() + "/tests";
}

}  // namespace palpate::test

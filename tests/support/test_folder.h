#pragma once

#include <string>

namespace palpate::test {

/// The folder `tests` of the sources.
std::string test_folder();

}  // namespace palpate::test

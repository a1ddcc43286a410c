#pragma once

#include <string>

namespace palpate::experiments {

/// The folder of the sources that this program was built from, baked in, since the launcher builds in place; of an installed program
/// the folder where what it reads of them lies in the same way: plans, scenes, descriptions of contestants, the report.
const std::string& source_folder();

/// The folder of the programs of this build (or that were installed), contestants' adapters among them.
const std::string& program_folder();

}  // namespace palpate::experiments

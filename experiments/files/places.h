#pragma once

#include <string>

namespace palpate::experiments {

/// The folder of the sources that this program was built from: plans, scenes, descriptions of contestants,
/// the report. Baked in, since the launcher builds in place.
const std::string& source_folder();

/// The folder of the programs of this build, contestants' adapters among them.
const std::string& program_folder();

}  // namespace palpate::experiments

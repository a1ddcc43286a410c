// Where the program finds what belongs to it: in the sources and the build folder, or where it was installed
// (docs/install.md).
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace palpate::experiments {

/// PREFIX of a program at PREFIX/lib/palpate/NAME beside which PREFIX/share/palpate lies; none if it was
/// built in place.
const std::optional<std::filesystem::path>& install_prefix();

/// The folder of the sources that this program was built from, baked in, since the launcher builds in place;
/// of an installed program the folder where what it reads of them lies in the same way: plans, scenes,
/// descriptions of contestants, the report.
const std::string& source_folder();

/// The folder of the programs of this build (or that were installed), contestants' adapters among them.
const std::string& program_folder();

/// The folder of the pages' scripts and style sheets.
std::filesystem::path page_folder();

/// Where runs go that are not told a place, and a user's own accepted figures: results/ of the sources; of an
/// installed program results/ in the current folder, never below PREFIX.
std::filesystem::path results_root();

/// Where caches go that are not told a place: the build folder; of an installed program palpate/ below
/// XDG_CACHE_HOME or ~/.cache. Throws: InputError if an installed program has neither.
std::filesystem::path default_cache_root();

}  // namespace palpate::experiments

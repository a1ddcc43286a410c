// The parts of a case's id. Ids are paths in a run folder, so that what a plan writes must not lead out of
// it.
#pragma once

#include <string>
#include <string_view>

namespace palpate::experiments {

/// `text` as one part of a path: letters, digits and "._-+,:" stay, every other byte becomes %XX. Different
/// texts give different parts. A long one keeps its start and ends in "%~" and a hash.
std::string safe_part(std::string_view text);

/// "name=value", both made safe. Of ordinary names and values that is what it reads like.
std::string case_part(std::string_view name, std::string_view value);

}  // namespace palpate::experiments

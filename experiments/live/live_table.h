// The finite elements' answer of a live page: the table of reduced.compliance, through its contestant.
#pragma once

#include <string>

#include "experiments/live/live_body.h"
#include "experiments/registry/registry.h"

namespace palpate::experiments {

/// Skins with more vertices have no table in a page: it would have over 58 MB.
inline constexpr std::size_t kMostTableVertices = 900;

/// Makes the table of the first level by quadratic elements, or says in no_table why there is none. Made ones
/// are kept, by the mesh and the contestant's hash.
void make_live_table(const Registry& registry, LiveBodyData& out);

/// The skin's part of a table's file (docs/reduced.md). Throws: InputError with `where` for a file that is
/// none of single precision with linear reactions.
LiveTable read_live_table(const std::string& bytes, const std::string& where);

}  // namespace palpate::experiments

// Requests of the fusion family (palpate.hierarchical, tetfusion.sequential) as options structs, and their
// reports.
#pragma once

#include "core/simplify/hierarchical.h"
#include "reference/adapter.h"

namespace palpate::reference {

/// Reads "stop" and the options that the fusion family shares, and removes them from `options`.
/// Throws: InputError for a wrong type, a value out of range or an unknown stop.
simplify::SimplifyOptions take_fusion_options(const nlohmann::json& stop, nlohmann::json& options);

/// Reads the regions to keep, and the options "near_size" and "reach", which are removed from `options`.
/// Throws: InputError for a region or a value that makes no sense.
simplify::SizingOptions take_sizing_options(const std::vector<std::string>& keep, nlohmann::json& options);

/// Takes a choice out of `options`: the position of its value in `choices`. Throws: InputError for any other.
std::size_t take_choice(nlohmann::json& options, const char* key, const std::vector<std::string>& choices);

/// Throws InputError naming the first option that nobody took.
void require_all_taken(const nlohmann::json& options);

/// Reads the mesh, calls `simplify` on it (the timed kernel), writes the result and reports as in cli.md.
Response run_fusion(const Request& request,
                    const std::function<simplify::SimplifyReport(TetMesh&)>& simplify);

}  // namespace palpate::reference

// Requests of the fusion family (palpate.hierarchical, tetfusion.sequential) as options structs, and their
// reports.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/simplify/fusion/fusion_options.h"
#include "reference/door/adapter.h"
#include "reference/door/request_options.h"

namespace palpate::reference {

/// Reads "stop" of a request. Throws: InputError for an unknown stop or a value that does not fit.
simplify::StopRule read_stop(const nlohmann::json& stop);

/// Reads "stop" and the options that the fusion family shares, and removes them from `options`.
/// Throws: InputError for a wrong type, a value out of range or an unknown stop.
simplify::SimplifyOptions take_fusion_options(const nlohmann::json& stop, nlohmann::json& options);

/// Reads the regions to keep, and the options "near_size" and "reach", which are removed from `options`.
/// Throws: InputError for a region or a value that makes no sense.
simplify::SizingOptions take_sizing_options(const std::vector<std::string>& keep, nlohmann::json& options);

/// Reads the mesh, calls `simplify` on it (the timed kernel), writes the result and reports what it did.
Response run_fusion(const Request& request,
                    const std::function<simplify::SimplifyReport(TetMesh&)>& simplify);

}  // namespace palpate::reference

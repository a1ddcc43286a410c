// Where a simplification ended above the count that was asked for: how far it got, what held it and what gets
// there.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/mesh/tet_mesh.h"
#include "experiments/contestants/contestant_run.h"
#include "experiments/registry/registry.h"

namespace palpate::experiments {

/// Where a skin that was left as it is keeps the mesh from what was asked for: what would coarsen it too.
/// Empty where less than three quarters of the tets touch the skin. `skin`, here and below, are the faces of
/// `out` that no two tets share.
std::string skin_hint(const TetMesh& in, const TetMesh& out, const std::vector<Triangle>& skin,
                      const std::string& method);

/// The most tets that may be left at a stop by count or by ratio; nothing for other stops.
std::optional<double> wanted_tets(const TetMesh& in, const Stop& stop);

/// How far a run came that has not reached its count, and what stood in its way; `report` is the run's.
nlohmann::json describe_shortfall(const TetMesh& in, const TetMesh& out, const std::vector<Triangle>& skin,
                                  double wanted, const nlohmann::json& report);

/// Adds as "way_out" what reaches the count: palpate.refined ("bound" null), or palpate.surface with the
/// least of some distances that does, in metres as its option has them, 0 among them, and not that of the
/// failed run if it is that method's. null stays if neither does, or if more tets than that are in regions to
/// keep. Each is run as it is said. What was tried is in "tried_bounds". Takes some seconds.
void find_way_out(const ContestantTask& failed, const TetMesh& in, const Registry& registry,
                  nlohmann::json& shortfall);

/// A shortfall in words.
std::string shortfall_text(const nlohmann::json& shortfall);

}  // namespace palpate::experiments

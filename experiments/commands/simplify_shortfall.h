// Where a simplification ended above the count that was asked for: how far it got, what held it and what gets
// there.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "core/mesh/tet_mesh.h"
#include "experiments/contestants/contestant.h"
#include "experiments/contestants/contestant_run.h"

namespace palpate::experiments {

/// Where a skin that was left as it is keeps the mesh from what was asked for: what would coarsen it too.
/// Empty where less than three quarters of the tets touch the skin.
std::string skin_hint(const TetMesh& in, const TetMesh& out, const std::string& method);

/// The most tets that may be left at a stop by count or by ratio; nothing for other stops.
std::optional<double> wanted_tets(const TetMesh& in, const Stop& stop);

/// How far a run came that has not reached its count, and what stood in its way; `report` is the run's.
nlohmann::json describe_shortfall(const TetMesh& in, const TetMesh& out, double wanted,
                                  const nlohmann::json& report);

/// Adds as "way_out" what reaches the count: palpate.refined ("bound" null), or palpate.surface with the
/// least of some distances, in metres as its option has them, beyond that of the failed run if it is that
/// method's. null stays if neither does, or if more tets than that are in regions to keep. Each is run as it
/// is said. What was tried is in "tried_bounds". Takes some seconds.
void find_way_out(const ContestantTask& failed, const TetMesh& in, const Registry& registry,
                  nlohmann::json& shortfall);

/// What of a mesh's skin is so bad that no inside makes up for it; null where nothing is.
///
///   faces   on which no tet has a mean ratio above `best_mean_ratio`: that of the best tet on a triangle of
///           area A and squared edges l^2 is (12 A / (sqrt(3) sum of l^2))^(2/3), with its apex over the
///           middle
///   edges   at which two faces meet inside at less than `least_angle_deg`: some tet there has no greater
///   angle
///
/// Each as "count" and, the worst first, up to ten of them by their vertices (from 1, as in the file) and
/// place.
nlohmann::json describe_poor_skin(const TetMesh& mesh);

/// The same in words.
std::string poor_skin_text(const nlohmann::json& skin);

/// A shortfall in words.
std::string shortfall_text(const nlohmann::json& shortfall);

}  // namespace palpate::experiments

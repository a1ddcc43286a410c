// What a scene has that is not as it was fitted, and that no axis of an envelope measures.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace palpate::experiments {

/// Everything that decides an answer but what an axis scales (sizes of loads and their times, stiffness,
/// density, step): the mesh's unit, strain, supports, places, beds, directions and profiles of loads, their
/// sizes to each other, integrator, precision, solver, damping, a longer motion, and a stricter requirement.
/// A key that is left out is its default. A line each; empty where all is as fitted. Requires: scenes that
/// read_scene accepts, their loads of the same kinds.
std::vector<std::string> differences_between(const nlohmann::json& fitted, const nlohmann::json& own);

/// The greatest share by which a time of a load (between two points of its profile, to its start, from there
/// to its end) is shorter than it was fitted; 1 or less where none is. Nothing where no time can be compared.
/// Requires: as above.
std::optional<double> times_shortened(const nlohmann::json& fitted, const nlohmann::json& own);

}  // namespace palpate::experiments

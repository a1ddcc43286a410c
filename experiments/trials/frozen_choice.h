// Which part of a body may be held at rest, and what acts on it there.
#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/types.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::experiments {

/// The vertices that move by at most `most_m`. Shape: one displacement a vertex, in m.
std::vector<Index> find_still(std::span<const Vec3> displacement_m, double most_m);

/// The tetrahedra all of whose vertices are in the list.
std::size_t count_still_tets(const TetMesh& mesh, const std::vector<Index>& still);

/// The root of the mean square displacement.
double rms_displacement(std::span<const Vec3> displacement_m);

/// What came of holding a part at rest.
struct FrozenTry {
  double share = 0.0;             ///< of the tolerance times the rms displacement: what moves less is held
  std::size_t vertices = 0;       ///< held
  std::size_t tets = 0;           ///< among them
  std::optional<double> error{};  ///< at rest, the largest with the reference's own on top
  std::optional<double> motion_error{};  ///< from the whole model's motion
  double cost_before_s = 0.0;            ///< a simulated second of the whole model; 0: not run
  double cost_s = 0.0;
  double most_force_n = 0.0;  ///< on the held part (dynamics::frozen_force), of all that it was verified on
  std::string why_not;        ///< empty: taken
};

/// Why a part is not held: it holds too little, is off by more than is left, or costs no less. Empty if it
/// is. Requires: figures of a part that was run.
std::string why_not_frozen(const FrozenTry& tried, std::size_t of_tets, double most_error);

/// The fewest tetrahedra that are worth it, as a share.
inline constexpr double kLeastFrozen = 0.05;

/// palpate/frozen/1. `most_force_n` is null until it is known.
nlohmann::json describe_frozen(const std::vector<Index>& still, std::size_t of_vertices,
                               std::optional<double> most_force_n);

/// Why a body whose model has the file of frozen vertices wakes: the report of its run has more force on the
/// held part than was verified. Empty if it does not. Throws: InputError for a file that says nothing of a
/// force.
std::string why_it_wakes(const std::filesystem::path& frozen_file, const nlohmann::json& report);

}  // namespace palpate::experiments

// A mesh that is graded by its scene: sizes, then a simplifier that follows them.
#pragma once

#include "core/mesh/tet_mesh.h"
#include "experiments/contestants/contestant_run.h"
#include "experiments/grading/graded_sizes.h"

namespace palpate::experiments {

/// What came of grading.
struct GradedMesh {
  std::string failure;    ///< why there is none; empty if there is
  TetMesh mesh;           ///< in metres
  GradedSizes wanted;     ///< at the vertices of the mesh before
  nlohmann::json report;  ///< the simplifier's
  std::optional<double> kernel_s;
  std::vector<std::string> notes;
};

/// Metres in a unit of the meshes that simplifiers get, here and in contests with `simplify`.
inline constexpr double kSimplifierUnitM = 1e-3;

/// What resolve_options makes of them, with that unit in an option `unit_m` that was not given.
nlohmann::json resolve_simplifier_options(const MethodSpec& method,
                                          const std::map<std::string, GivenOption>& given);

/// The tets that a stop leaves of so many. Throws: InputError for a stop without a count.
std::uint64_t tets_after(const Stop& stop, std::uint64_t tets);

/// Grades a mesh in metres by a method of the contest simplify that takes sizes; it sees millimetres, and an
/// option unit_m that was not given says so. `options` are all of the method's, without sizes. The judge has
/// not looked at the mesh. Throws: InputError as find_graded_sizes, and for a method without the option.
GradedMesh make_graded_mesh(const GradeWish& wish, const GradedBody& body, const MethodEntry& simplifier,
                            const std::map<std::string, GivenOption>& options, const Stop& stop,
                            const PilotSetting& setting);

}  // namespace palpate::experiments

// What the judge finds in an answer of the contest engine, and what it can only report.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/base/types.h"
#include "core/mesh/tet_mesh.h"
#include "reference/door/motion_problem.h"

namespace palpate::experiments {

/// The figures that the judge computes from the file that an answer left (palpate/engine/1):
///
///   replay  how the body comes back after each tool (`returns`, and the worst of each figure), the largest
///           displacement and speed in its rows, inverted tets in its frames
///   rest    the slowest decay of its rates
///   ticks   the mean force over the last tenth of the ticks, and how far single ones are from it
///
/// `kind` names which; `valid` is false, with `findings`, unless the report's outcome is "completed" and the
/// file's numbers are finite and fit problem and mesh. Other files (models) are judged by their outcome
/// alone. Throws: InputError for a file that cannot be read.
nlohmann::json judge_engine_file(const reference::MotionProblem& problem, const TetMesh& mesh,
                                 const nlohmann::json& report, const std::filesystem::path& file);

/// The contestant's own word: figures of its report that nobody else can compute (times of a clock, what
/// happened between rows). Numbers alone.
nlohmann::json reported_figures(const nlohmann::json& report);

/// The force of the reference.
struct ReferenceForce {
  Vec3 force_n;
  std::optional<double> change;  ///< by its last refinement, over its size
};

/// Holds the judged force of ticks against the reference's, in `figures`.
void compare_force(const ReferenceForce& reference, nlohmann::json& figures);

}  // namespace palpate::experiments

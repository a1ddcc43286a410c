// What is asked of a contestant outside of a plan: by simulate, check and export.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "core/mesh/tet_mesh.h"
#include "experiments/contestants/contestant_run.h"
#include "experiments/registry/registry.h"
#include "reference/door/moving_body.h"

namespace palpate::experiments {

/// Writes mesh and problem below `folder`, which is made, and asks for a method of any contest that takes a
/// problem, with its default options. The task has no time-out. Throws: InputError if the folder cannot be
/// written, UnavailableError if the method cannot run here.
ContestantTask start_task(const std::string& method, const nlohmann::json& problem, const TetMesh& mesh,
                          const Registry& registry, const std::filesystem::path& folder);

/// Writes mesh and body below `folder`, which is made, and asks for a method of the contest engine with its
/// default options. The task has no time-out. Throws: InputError if the folder cannot be written,
/// UnavailableError if the engine cannot run here.
ContestantTask start_moving_task(const std::string& method, const reference::MovingBody& body,
                                 const TetMesh& mesh, const Registry& registry,
                                 const std::filesystem::path& folder);

/// Asks for the motion of a body from start to end: engine.replay, or reduced.modal_replay with the options
/// of the body's modes and the scene's step. Throws: as start_moving_task.
ContestantTask start_replay(const reference::MovingBody& body, const TetMesh& mesh, const Registry& registry,
                            const std::filesystem::path& folder);

/// Runs it, and returns an answer that is "ok" or "interrupted". Throws: InputError that starts with `where`
/// for what the engine refuses, UnavailableError for any other end.
ContestantAnswer run_moving_task(const ContestantTask& task, const std::string& where);

}  // namespace palpate::experiments

// A first scene of a user's organ, drafted from its mesh.
#pragma once

#include <filesystem>

#include "core/mesh/boundary_problem.h"
#include "experiments/scene_writer/scene_wish.h"

namespace palpate::experiments {

/// Makes the organ's mesh and drafts the scene: elastic supports of E / 10 mm on the underside, an elastic
/// pad of E / 2 mm on top that is pushed inward, gravity. Nothing is written. Throws: InputError if no unit
/// makes an organ of it and none is given, and as build_scene_mesh() does.
SceneDraft draft_scene(const SceneWish& wish);

/// Reads the written scene as `check` does, and puts it on its mesh. Throws: as read_scene, build_scene_mesh
/// and build_problem do.
BoundaryProblem resolve_draft(const std::filesystem::path& scene);

}  // namespace palpate::experiments

// A scene with what a sweep changes of it.
#pragma once

#include <nlohmann/json.hpp>

#include "core/mesh/tet_mesh.h"
#include "experiments/scene_reader/scene.h"

namespace palpate::experiments {

/// A swept scene, placed on its mesh.
struct SweptScene {
  Scene placed;
  TetMesh mesh;
};

/// `sweep` holds poisson_ratio, vertices, both or neither; other keys are not looked at. Throws: InputError
/// or UnavailableError as build_scene_mesh and place_scene do.
SweptScene place_swept_scene(Scene scene, const nlohmann::json& sweep);

}  // namespace palpate::experiments

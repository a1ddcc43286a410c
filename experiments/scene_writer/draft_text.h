// The text of a drafted scene.
#pragma once

#include <string>

#include "experiments/scene_writer/scene_wish.h"

namespace palpate::experiments {

/// The direction of an axis. Throws: InputError for another letter than x, y or z.
Vec3 up_direction(char up);

/// The scene as YAML, with comments on what was found and what can be changed.
std::string write_draft(const SceneWish& wish, const SceneDraft& draft);

}  // namespace palpate::experiments

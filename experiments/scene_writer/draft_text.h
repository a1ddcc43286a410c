// The text of a drafted scene.
#pragma once

#include <array>
#include <string>

#include "experiments/scene_writer/scene_wish.h"

namespace palpate::experiments {

/// What up_direction takes.
inline constexpr std::array kUpNames{"+x", "-x", "+y", "-y", "+z", "-z", "x", "y", "z"};

/// The direction of an axis; without a sign it is +. Throws: InputError for what is none of kUpNames.
Vec3 up_direction(const std::string& up);

/// The same axis with the other sign; + is not written.
std::string other_way(const std::string& up);

/// The scene as YAML, with comments on what was found and what can be changed.
std::string write_draft(const SceneWish& wish, const SceneDraft& draft);

}  // namespace palpate::experiments

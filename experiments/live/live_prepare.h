// From a mesh, a scene or a fit to what a live page needs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "experiments/live/live_body.h"
#include "experiments/registry/registry.h"

namespace palpate::experiments {

/// What is asked for. A scene and a fit have a unit, a count of vertices and a material of their own: none
/// may be asked for with them.
struct LiveWish {
  std::filesystem::path source;  ///< a mesh, a surface, a scene (.yaml), or the folder of a fit
  std::optional<double> unit_m;
  std::optional<std::uint64_t> vertices;
  std::optional<Material> material;  ///< none: kUsualMaterial
  bool with_table = true;
};

/// Makes it. A mesh without a scene gets the supports and the unit that `palpate scene` finds. Throws:
/// InputError for what is no such source, and as read_scene and build_scene_mesh; UnavailableError as they
/// do.
LiveBodyData prepare_live(const LiveWish& wish, const Registry& registry);

}  // namespace palpate::experiments

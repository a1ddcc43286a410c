// A first scene of a user's organ, drafted from its mesh.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/mesh/boundary_problem.h"
#include "core/mesh/tet_mesh.h"
#include "experiments/scene_writer/skin_regions.h"
#include "experiments/scene_writer/unit_guess.h"

namespace palpate::experiments {

/// What is asked for; all else is found on the body.
struct SceneWish {
  std::filesystem::path organ;  ///< a surface or tetrahedra
  std::filesystem::path scene;  ///< the file to write
  std::optional<double> unit_m;
  std::optional<std::uint64_t> vertices;  ///< of a surface's filling
  bool repair = false;                    ///< of a surface
  Material material{10000.0, 0.45, 1050.0};
  bool is_dynamic = false;
  char up = 'z';
};

/// What was found, and the scene's text.
struct SceneDraft {
  TetMesh mesh;  ///< in metres
  std::vector<std::string> notes;
  bool is_surface = false;
  std::optional<std::uint64_t> vertices;  ///< that a surface is filled to; nothing: its skin as it is
  double unit_m = 0.0;
  std::string unit_reason;  ///< "guessed: with mm it is 12.3 cm across"
  Vec3 size_m;              ///< of its box
  RestingRegion support;
  PadRegion pad;
  Vec3 push_m;  ///< 5% of the thickness below the pad, inward
  std::string yaml;
};

/// Makes the organ's mesh and drafts the scene: elastic supports of E / 10 mm on the underside, an elastic pad of
/// E / 2 mm on top that is pushed inward, gravity. Nothing is written. Throws: InputError if no unit makes an organ of
/// it and none is given, and as build_scene_mesh() does.
SceneDraft draft_scene(const SceneWish& wish);

/// Reads the written scene as `check` does, and puts it on its mesh. Throws: as read_scene, build_scene_mesh and
/// build_problem do.
BoundaryProblem resolve_draft(const std::filesystem::path& scene);

}  // namespace palpate::experiments

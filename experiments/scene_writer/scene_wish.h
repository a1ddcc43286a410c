// What a first scene is to be, and what was found for it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/mesh/boundary_problem.h"
#include "core/mesh/tet_mesh.h"
#include "experiments/scene_writer/skin_regions.h"

namespace palpate::experiments {

/// Of a body whose material nobody gives: some organ's, nearly incompressible.
inline constexpr Material kUsualMaterial{10000.0, 0.45, 1050.0};

/// What is asked for; all else is found on the body.
struct SceneWish {
  std::filesystem::path organ;  ///< a surface or tetrahedra
  std::filesystem::path scene;  ///< the file to write
  std::optional<double> unit_m;
  std::optional<std::uint64_t> vertices;  ///< of a surface's filling
  bool repair = false;                    ///< of a surface
  Material material = kUsualMaterial;
  bool is_dynamic = false;
  std::optional<std::string> up;  ///< as up_direction takes it; nothing: the axis along which it is shortest
};

/// What was found, and the scene's text.
struct SceneDraft {
  TetMesh mesh;  ///< in metres
  std::vector<std::string> notes;
  bool is_surface = false;
  std::optional<std::uint64_t> vertices;  ///< that a surface is filled to; nothing: its skin as it is
  double unit_m = 0.0;
  std::string unit_reason;    ///< "guessed: with mm it is 12.3 cm across"
  Vec3 size_m;                ///< of its box
  std::string up = "z";       ///< "x", "-x", "y", "-y", "z" or "-z"
  bool up_is_chosen = false;  ///< as the axis along which it is shortest
  RestingRegion support;
  PadRegion pad;
  Vec3 push_m;  ///< 5% of the thickness below the pad, inward
  std::string yaml;
};

}  // namespace palpate::experiments

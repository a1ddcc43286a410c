// A shape as it is asked for, and what comes of it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/enum_names.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::experiments {

inline constexpr std::uint64_t kDefaultVertices = 1503;  ///< of the thesis's mesh
inline constexpr std::uint64_t kFewestVertices = 100;    ///< that a body may be asked for

/// How fine a made mesh is to be; at most one of the two. Without either, a shape takes its own default.
struct MeshSize {
  std::optional<std::uint64_t> vertices{};
  std::optional<double> edge_length{};  ///< of the interior, in the shape's own unit
};

/// How the skin of a filled body is, beside its interior.
enum class SkinKind {
  kCoarse,   ///< edges some 2.2 times as long as inside, as in the thesis's mesh
  kFine,     ///< as long as inside, as users' meshes have
  kScanned,  ///< by marching cubes on voxels as wide as edges inside are long: with needles
};

inline constexpr EnumNames<SkinKind, 3> kSkinKinds{"skin", {"coarse", "fine", "scanned"}};

/// A shape by name, as in `palpate make` and in plans.
struct ShapeRequest {
  std::string name;
  MeshSize size{};
  std::uint64_t seed = 0;  ///< another mesh of the same body; cube: of its jitter. Lattices have none.
  std::optional<double> jitter{};     ///< cube only: largest move of an inner vertex, in cells
  SkinKind skin = SkinKind::kCoarse;  ///< of filled bodies only
};

/// A mesh and one line for each thing worth saying about how it came about.
struct MadeMesh {
  TetMesh mesh;
  std::vector<std::string> notes;
};

}  // namespace palpate::experiments

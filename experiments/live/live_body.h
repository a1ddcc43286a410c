// What a live page needs of a body, made before it opens: meshes at several levels, what holds them, springs.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/mesh/boundary_problem.h"
#include "core/mesh/spring_network.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::experiments {

/// One level of simplification, in metres.
struct LiveLevel {
  double removed_ratio = 0.0;  ///< tets, by palpate.refined; 0: the mesh as it is
  TetMesh mesh;
  BoundaryProblem holding;  ///< material, supports and held faces alone
  SpringNetwork springs;    ///< of the material itself
  /// Each vertex's number in the mesh that was given; empty: simplified, it has none there.
  std::vector<Index> given_number;
};

/// The table of the first level, as its file has it (docs/reduced.md): the skin's part of it.
struct LiveTable {
  std::vector<std::uint32_t> vertices;  ///< of the skin, rising
  std::vector<float> skin;              ///< 3 n x 3 n
  std::vector<float> field;             ///< of the skin's rows, 3 n x 3 n
};

struct LiveBodyData {
  std::string title;
  std::string kind;  ///< "mesh", "scene" or "fit"
  Material material;
  double damping_stiffness_s = 0.0;
  double damping_mass_per_s = 0.0;
  double pad_radius_m = 0.0;
  double pad_pa_per_m = 0.0;
  /// What the page starts with: model ("springs", "smoothed" or "reduced"), and options of it.
  nlohmann::json start;
  nlohmann::json spring_source;  ///< method and options that the springs come from
  std::vector<LiveLevel> levels;
  std::optional<LiveTable> table;
  std::string no_table;  ///< why there is none
  std::vector<std::string> notes;
};

}  // namespace palpate::experiments

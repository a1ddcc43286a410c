// palpate.refined: collapse, then repair until the mesh is as good as a remesher's, with the boundary
// untouched.
#pragma once

#include <cstdint>
#include <string>

#include "core/mesh/tet_mesh.h"
#include "core/simplify/edge_collapse.h"
#include "core/simplify/hierarchical.h"
#include "core/simplify/sizing.h"

namespace palpate::simplify {

inline constexpr int kMostEffort = 5;

struct RefinedOptions {
  StopRule stop;   ///< tets or ratio; `fusions` is refused
  int effort = 1;  ///< 0 .. kMostEffort: more sweeps, better and slower
  CollapsePlacement collapse_placement = CollapsePlacement::kBest;
  bool smoothing = true;
  bool edge_removal = true;
  bool face_removal = true;
  SizingOptions sizing;
};

struct RefinedReport {
  std::uint64_t vertices_in = 0;
  std::uint64_t vertices_out = 0;
  std::uint64_t tets_in = 0;
  std::uint64_t tets_out = 0;
  std::uint64_t collapses = 0;
  std::uint64_t moves = 0;  ///< of vertices
  std::uint64_t edges_removed = 0;
  std::uint64_t faces_removed = 0;
  std::string stop;  ///< "tets", "ratio" or "limit"
  CollapseReport rejected;
};

/// Throws: InputError for a ratio outside [0, 1), an effort out of range, or a stop by fusions.
void validate_options(const RefinedOptions& options);

RefinedReport simplify_refined(TetMesh& mesh, const RefinedOptions& options);

}  // namespace palpate::simplify

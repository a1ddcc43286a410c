// What a run of simplify_surface is asked for, and what it reports.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/mesh/tet_mesh.h"
#include "core/simplify/fusion/fusion_options.h"
#include "core/simplify/refined/stable_step.h"
#include "core/simplify/sizing/sizing.h"
#include "core/simplify/surface/surface_collapse.h"
#include "core/simplify/tet_operations/edge_collapse.h"

namespace palpate::simplify {

/// How far boundary and inside are coarsened, and by which means.
struct SurfaceOptions {
  StopRule stop;                   ///< tets or ratio; neither: as coarse as the bound permits; no `fusions`
  double max_surface_error = 0.0;  ///< two-sided Hausdorff distance of the skins, in the mesh's unit
  Objective objective = Objective::kShape;
  int effort = 1;                  ///< 0 .. kMostEffort of refined.h: more sweeps, better and slower
  bool sparing = true;             ///< the bound in steps, no more than good tets need; else spent
  double boundary_size = 1.0;      ///< edges of the boundary over those inside, to aim at
  bool boundary_flips = true;      ///< of edges
  bool boundary_smoothing = true;  ///< boundary vertices move along the skin too
  double feature_deg = 0.0;        ///< edges sharper than this are kept as lines (FeatureLines); 0: none
  SizingOptions sizing;
};

/// What was done.
struct SurfaceRunReport {
  std::uint64_t vertices_in = 0;
  std::uint64_t vertices_out = 0;
  std::uint64_t tets_in = 0;
  std::uint64_t tets_out = 0;
  std::uint64_t boundary_faces_in = 0;
  std::uint64_t boundary_faces_out = 0;
  double volume_drift_relative = 0.0;   ///< |V_out - V_in| / V_in
  std::uint64_t feature_edges_in = 0;   ///< sharper than feature_deg
  std::uint64_t feature_edges_out = 0;  ///< what their lines have become
  std::uint64_t feature_corners = 0;    ///< vertices where they end, meet or turn: these stay
  std::optional<Vec3> input_contact;    ///< a place where the input's skin meets itself, if there is one
  std::string stop;                     ///< "tets", "ratio" or "limit"
  SurfaceReport surface;
  CollapseReport inner;
};

}  // namespace palpate::simplify

// What the judge says, as the flat JSON object that records and `palpate quality --json` hold.
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "core/judge/mesh/judge.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::experiments {

/// The judge's verdict on one mesh.
struct Judgement {
  judge::Validity validity;
  nlohmann::json figures;               ///< flat; see record.schema.json
  std::vector<std::string> violations;  ///< why the mesh is invalid, one line each
};

/// Judges a mesh by itself.
Judgement judge_mesh(const TetMesh& mesh);

/// Judges an output: by itself, by the input's ideal volume (keys that end in _input_ideal), and against the
/// input; kept_tets and kept_tets_changed are of the regions to keep (see
/// experiments/judging/kept_regions.h), 0 without any.
Judgement judge_output(const TetMesh& output, const TetMesh& input, std::span<const std::string> keep = {});

/// Adds region_tets, the tets of `mesh` that meet a region of the plan (patches: of the input's boundary), to
/// figures of a mesh with sound arrays. Adds nothing without regions.
void add_region_figures(nlohmann::json& figures, const TetMesh& mesh, const TetMesh& input,
                        std::span<const std::string> regions);

/// Adds how far the input's sharp edges are from those of an output with sound arrays
/// (core/judge/surface/feature_distance.h): feature_edges, feature_distance_lower, feature_distance_upper.
void add_feature_figures(nlohmann::json& figures, const TetMesh& output, const TetMesh& input,
                         double feature_deg);

/// Whether a measure is one of these.
bool is_of_features(const std::string& measure);

/// Adds what a mesh with sound arrays is worth to linear elements
/// (core/judge/linear_elements/linear_elements.h): p1_error, p1_error_worst, stiffness_condition,
/// scaled_condition, max_stiffness_eigenvalue, max_scaled_eigenvalue, explicit_step; null, with the judge's
/// reason, where there is none. It takes seconds for 100,000 tets, so it is done only where it is asked for.
void add_linear_element_figures(nlohmann::json& figures, const TetMesh& mesh);

/// Whether a measure is one of these.
bool is_of_linear_elements(const std::string& measure);

/// A finite number as itself, any other as null; adds "key: reason" to `reasons` for the latter.
nlohmann::json finite_or_null(double value, const std::string& key, nlohmann::json& reasons);

}  // namespace palpate::experiments

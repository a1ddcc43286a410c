#include "experiments/judging/judge_record.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/judge/linear_elements/linear_elements.h"
#include "core/judge/surface/feature_distance.h"
#include "core/judge/surface/surface.h"
#include "experiments/judging/kept_regions.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

void add_validity(json& figures, const judge::Validity& validity) {
  figures["valid"] = validity.is_valid();
  figures["index_errors"] = validity.index_errors;
  figures["non_finite_points"] = validity.non_finite_points;
  figures["inverted_tets"] = validity.inverted_tets;
  figures["flat_tets"] = validity.flat_tets;
  figures["duplicate_tets"] = validity.duplicate_tets;
  figures["nonmanifold_faces"] = validity.nonmanifold_faces;
  figures["folded_faces"] = validity.folded_faces;
  figures["nonmanifold_edges"] = validity.nonmanifold_edges;
  figures["nonmanifold_vertices"] = validity.nonmanifold_vertices;
  figures["isolated_vertices"] = validity.isolated_vertices;
  figures["findings"] = validity.findings;
}

void add_counts(json& figures, const judge::Counts& counts) {
  figures["vertices"] = counts.vertices;
  figures["edges"] = counts.edges;
  figures["faces"] = counts.faces;
  figures["tets"] = counts.tets;
  figures["boundary_vertices"] = counts.boundary_vertices;
  figures["boundary_edges"] = counts.boundary_edges;
  figures["boundary_faces"] = counts.boundary_faces;
  figures["components"] = counts.components;
  figures["boundary_components"] = counts.boundary_components;
  figures["euler"] = counts.euler;
  figures["boundary_euler"] = counts.boundary_euler;
  figures["formula_a1"] = counts.formula_a1;
  figures["formula_a2"] = counts.formula_a2;
  figures["formula_a3"] = counts.formula_a3;
}

void add_real(json& figures, const std::string& key, double value) {
  json reasons = figures.value("null_reasons", json::object());
  figures[key] = finite_or_null(value, key, reasons);
  if (!reasons.empty()) figures["null_reasons"] = std::move(reasons);
}

void add_spread(json& figures, const std::string& name, const judge::Spread& spread) {
  add_real(figures, "mean_" + name, spread.mean);
  add_real(figures, "p5_" + name, spread.p5);
  add_real(figures, "p1_" + name, spread.p1);
  add_real(figures, "min_" + name, spread.least);
}

void add_quality(json& figures, const judge::Quality& quality) {
  figures["histogram"] = quality.histogram;
  add_real(figures, "volume", quality.volume);
  add_real(figures, "ideal_volume", quality.ideal_volume);
  add_real(figures, "percent_above_0_5", quality.percent_above_0_5);
  add_real(figures, "percent_above_0_6", quality.percent_above_0_6);
  add_real(figures, "mean_quality", quality.mean_quality);
  add_real(figures, "min_quality", quality.min_quality);
  add_real(figures, "min_dihedral_deg", quality.min_dihedral_deg);
  add_real(figures, "p1_dihedral_deg", quality.p1_dihedral_deg);
  add_real(figures, "p5_dihedral_deg", quality.p5_dihedral_deg);
  add_real(figures, "max_dihedral_deg", quality.max_dihedral_deg);
  add_real(figures, "p99_max_dihedral_deg", quality.p99_max_dihedral_deg);
  add_real(figures, "p95_max_dihedral_deg", quality.p95_max_dihedral_deg);
  add_spread(figures, "mean_ratio", quality.mean_ratio);
  add_spread(figures, "radius_ratio", quality.radius_ratio);
  add_spread(figures, "edge_ratio", quality.edge_ratio);
}

/// How far the skin moved, and how much more it is bent. A skin that is the input's to the bit costs nothing
/// here.
void add_surface_distance(json& figures, const TetMesh& output, const TetMesh& input, bool is_unchanged) {
  judge::SurfaceDistance distance;
  double bend_ratio = 1.0;
  if (!is_unchanged) {
    const SurfaceMesh after = judge::build_boundary(output);
    const SurfaceMesh before = judge::build_boundary(input);
    distance = judge::measure_surface_distance(after, before);
    const double bend = after.triangles.empty() ? std::nan("") : judge::total_bend(after);
    bend_ratio = bend / judge::total_bend(before);
  }
  add_real(figures, "boundary_bend_ratio", bend_ratio);
  add_real(figures, "surface_distance_lower", distance.lower());
  add_real(figures, "surface_distance_upper", distance.upper());
  add_real(figures, "surface_distance_relative",
           distance.diagonal > 0.0 ? distance.upper() / distance.diagonal : distance.upper());
  add_real(figures, "mean_surface_distance", distance.mean());
  add_real(figures, "mean_surface_distance_error",
           std::max(distance.forward.mean_error, distance.backward.mean_error));
}

bool has_sound_arrays(const judge::Validity& validity) {
  return validity.index_errors == 0 && validity.non_finite_points == 0;
}

}  // namespace

json finite_or_null(double value, const std::string& key, json& reasons) {
  if (std::isfinite(value)) return value;
  reasons[key] = std::isnan(value) ? "not a number" : "infinite";
  return nullptr;
}

Judgement judge_mesh(const TetMesh& mesh) {
  Judgement judgement;
  judgement.validity = judge::check_validity(mesh);
  judgement.figures = json::object();
  add_validity(judgement.figures, judgement.validity);
  if (!judgement.validity.is_valid()) {
    judgement.violations = judgement.validity.findings;
    if (judgement.violations.empty()) judgement.violations.emplace_back("the mesh is invalid");
  }
  if (!has_sound_arrays(judgement.validity)) return judgement;
  add_counts(judgement.figures, judge::count_elements(mesh));
  add_quality(judgement.figures, judge::measure_quality(mesh));
  judgement.figures["surface_self_intersections"] =
      judge::count_self_intersections(judge::build_boundary(mesh));
  return judgement;
}

Judgement judge_output(const TetMesh& output, const TetMesh& input, std::span<const std::string> keep) {
  Judgement judgement = judge_mesh(output);
  if (!has_sound_arrays(judgement.validity)) return judgement;
  json& figures = judgement.figures;
  const double ideal_volume = judge::measure_quality(input).ideal_volume;
  const judge::Quality quality = judge::measure_quality(output, ideal_volume);
  figures["histogram_input_ideal"] = quality.histogram;
  add_real(figures, "percent_above_0_5_input_ideal", quality.percent_above_0_5);
  add_real(figures, "percent_above_0_6_input_ideal", quality.percent_above_0_6);
  add_real(figures, "mean_quality_input_ideal", quality.mean_quality);
  add_real(figures, "min_quality_input_ideal", quality.min_quality);
  const judge::Comparison comparison = judge::compare_with_input(output, input);
  figures["boundary_missing_faces"] = comparison.boundary_missing_faces;
  figures["boundary_new_faces"] = comparison.boundary_new_faces;
  figures["boundary_changed_faces"] = comparison.boundary_changed_faces;
  add_real(figures, "volume_drift_relative", comparison.volume_drift_relative);
  figures["euler_unchanged"] = comparison.euler_unchanged;
  figures["components_unchanged"] = comparison.components_unchanged;
  const judge::RegionFigures kept = judge::compare_in_regions(output, input, judge_regions(keep));
  figures["kept_tets"] = kept.input_tets;
  figures["kept_tets_changed"] = kept.changed_tets;
  add_surface_distance(figures, output, input, comparison.boundary_changed_faces == 0);
  return judgement;
}

void add_region_figures(json& figures, const TetMesh& mesh, const TetMesh& input,
                        std::span<const std::string> regions) {
  if (regions.empty() || figures.value("index_errors", 0) != 0 || figures.value("non_finite_points", 0) != 0)
    return;
  figures["region_tets"] = judge::compare_in_regions(mesh, input, judge_regions(regions)).output_tets;
}

void add_feature_figures(json& figures, const TetMesh& output, const TetMesh& input, double feature_deg) {
  if (figures.value("index_errors", 0) != 0 || figures.value("non_finite_points", 0) != 0) return;
  const judge::FeatureDistance found = judge::measure_feature_distance(
      judge::build_boundary(input), judge::build_boundary(output), feature_deg);
  figures["feature_edges"] = found.input_edges;
  add_real(figures, "feature_distance_lower", found.kept.lower);
  add_real(figures, "feature_distance_upper", found.kept.upper);
}

bool is_of_features(const std::string& measure) {
  return measure.starts_with("feature_");
}

bool is_of_linear_elements(const std::string& measure) {
  constexpr std::array kNames{"p1_error",         "p1_error_worst",           "stiffness_condition",
                              "scaled_condition", "max_stiffness_eigenvalue", "max_scaled_eigenvalue",
                              "explicit_step"};
  return std::find(kNames.begin(), kNames.end(), measure) != kNames.end();
}

void add_linear_element_figures(json& figures, const TetMesh& mesh) {
  if (figures.value("index_errors", 0) != 0 || figures.value("non_finite_points", 0) != 0) return;
  const judge::LinearElementFigures found = judge::measure_linear_elements(mesh);
  const std::array<std::pair<const char*, double>, 7> named{
      {{"p1_error", found.p1_error},
       {"p1_error_worst", found.p1_error_worst},
       {"stiffness_condition", found.stiffness_condition},
       {"scaled_condition", found.scaled_condition},
       {"max_stiffness_eigenvalue", found.max_stiffness_eigenvalue},
       {"max_scaled_eigenvalue", found.max_scaled_eigenvalue},
       {"explicit_step", found.explicit_step}}};
  for (const auto& [key, value] : named) {
    figures[key] = found.reason.empty() ? json(value) : json();
    if (!found.reason.empty()) figures["null_reasons"][key] = found.reason;
  }
}

}  // namespace palpate::experiments

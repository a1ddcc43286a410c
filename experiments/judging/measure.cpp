#include "experiments/judging/measure.h"

#include <array>
#include <cmath>
#include <string_view>

namespace palpate::experiments {
namespace {

constexpr std::array kMeasures{
    Measure{"quality_histogram", "tets", "", "/judge/histogram", "tets in 10 equal buckets of quality",
            false},
    Measure{"percent_above_0_5", "%", "higher", "/judge/percent_above_0_5", "tets of quality above 0.5"},
    Measure{"percent_above_0_6", "%", "higher", "/judge/percent_above_0_6", "tets of quality above 0.6"},
    Measure{"mean_quality", "1", "higher", "/judge/mean_quality",
            "mean over the tets of the quality q = cbrt(q1 q2 q3): q1 = least solid angle / 0.55 sr, q2 = "
            "shortest / longest edge, q3 = min(1, V / mean V)"},
    Measure{"min_quality", "1", "higher", "/judge/min_quality", "least quality of a tet"},
    Measure{"percent_above_0_5_input_ideal", "%", "higher", "/judge/percent_above_0_5_input_ideal",
            "the same with the input's ideal volume"},
    Measure{"percent_above_0_6_input_ideal", "%", "higher", "/judge/percent_above_0_6_input_ideal",
            "the same with the input's ideal volume"},
    Measure{"mean_quality_input_ideal", "1", "higher", "/judge/mean_quality_input_ideal",
            "the same with the input's ideal volume"},
    Measure{"min_dihedral_deg", "deg", "higher", "/judge/min_dihedral_deg", "least dihedral angle"},
    Measure{"p1_dihedral_deg", "deg", "higher", "/judge/p1_dihedral_deg",
            "1st percentile of the tets' least dihedral angles"},
    Measure{"p5_dihedral_deg", "deg", "higher", "/judge/p5_dihedral_deg",
            "5th percentile of the tets' least dihedral angles"},
    Measure{"max_dihedral_deg", "deg", "lower", "/judge/max_dihedral_deg", "greatest dihedral angle"},
    Measure{"p99_max_dihedral_deg", "deg", "lower", "/judge/p99_max_dihedral_deg",
            "99th percentile of the tets' greatest dihedral angles"},
    Measure{"p95_max_dihedral_deg", "deg", "lower", "/judge/p95_max_dihedral_deg",
            "95th percentile of the tets' greatest dihedral angles"},
    Measure{"mean_mean_ratio", "1", "higher", "/judge/mean_mean_ratio",
            "mean of the mean ratio 12 (3 V)^(2/3) / sum l^2 over the tets"},
    Measure{"p5_mean_ratio", "1", "higher", "/judge/p5_mean_ratio",
            "5th percentile of the mean ratio 12 (3 V)^(2/3) / sum l^2 over the tets"},
    Measure{"p1_mean_ratio", "1", "higher", "/judge/p1_mean_ratio",
            "1st percentile of the mean ratio 12 (3 V)^(2/3) / sum l^2 over the tets"},
    Measure{"min_mean_ratio", "1", "higher", "/judge/min_mean_ratio",
            "least of the mean ratio 12 (3 V)^(2/3) / sum l^2 over the tets"},
    Measure{"mean_radius_ratio", "1", "higher", "/judge/mean_radius_ratio",
            "mean of the radius ratio 3 r / R, inscribed over circumscribed, over the tets"},
    Measure{"p5_radius_ratio", "1", "higher", "/judge/p5_radius_ratio",
            "5th percentile of the radius ratio 3 r / R, inscribed over circumscribed, over the tets"},
    Measure{"p1_radius_ratio", "1", "higher", "/judge/p1_radius_ratio",
            "1st percentile of the radius ratio 3 r / R, inscribed over circumscribed, over the tets"},
    Measure{"min_radius_ratio", "1", "higher", "/judge/min_radius_ratio",
            "least of the radius ratio 3 r / R, inscribed over circumscribed, over the tets"},
    Measure{"mean_edge_ratio", "1", "higher", "/judge/mean_edge_ratio",
            "mean of the shortest / longest edge over the tets"},
    Measure{"p5_edge_ratio", "1", "higher", "/judge/p5_edge_ratio",
            "5th percentile of the shortest / longest edge over the tets"},
    Measure{"p1_edge_ratio", "1", "higher", "/judge/p1_edge_ratio",
            "1st percentile of the shortest / longest edge over the tets"},
    Measure{"min_edge_ratio", "1", "higher", "/judge/min_edge_ratio",
            "least of the shortest / longest edge over the tets"},
    Measure{"p1_error", "1", "lower", "/judge/p1_error",
            "error of linear elements on quadratic fields that need no body force, |u - u_h| / |u| in the "
            "energy norm, nu "
            "0.3: root mean square over the 15; seconds at 100k tets, computed where a plan names it"},
    Measure{"p1_error_worst", "1", "lower", "/judge/p1_error_worst",
            "the same for the worst of these fields"},
    Measure{"explicit_step", "1", "higher", "/judge/explicit_step",
            "longest stable explicit step with linear elements and lumped masses, 2 / omega_max, over cbrt(V "
            "/ tets) "
            "sqrt(rho / E)"},
    Measure{"stiffness_condition", "1", "lower", "/judge/stiffness_condition",
            "greatest over least eigenvalue of the stiffness of linear elements, rigid motions left out"},
    Measure{"scaled_condition", "1", "lower", "/judge/scaled_condition",
            "the same of the stiffness scaled by its 3 x 3 diagonal blocks: iterative solvers' steps grow "
            "with its root"},
    Measure{"max_stiffness_eigenvalue", "1", "lower", "/judge/max_stiffness_eigenvalue",
            "greatest eigenvalue of the stiffness of linear elements, over E cbrt(V / tets): the part of the "
            "condition that is the tets'; the least eigenvalue hangs mostly on the body"},
    Measure{"max_scaled_eigenvalue", "1", "lower", "/judge/max_scaled_eigenvalue",
            "greatest eigenvalue of the stiffness scaled by its 3 x 3 diagonal blocks"},
    Measure{"kernel_s", "s", "lower", "/kernel_s", "time of the method alone, by its adapter"},
    Measure{"wall_s", "s", "lower", "/wall_s", "time of the whole process, files included"},
    Measure{"user_s", "s", "lower", "/user_s", "processor time of the process"},
    Measure{"peak_rss_bytes", "bytes", "lower", "/peak_rss_bytes", "largest resident memory of the process"},
    Measure{"tets", "1", "", "/judge/tets", "tetrahedra left"},
    Measure{"tets_out", "1", "", "/judge/tets", "the same, by the name that adapters use"},
    Measure{"fusions", "1", "", "/report/fusions", "fusions that the method reports"},
    Measure{"vertices", "1", "", "/judge/vertices", "vertices left"},
    Measure{"edges", "1", "", "/judge/edges", "edges left"},
    Measure{"faces", "1", "", "/judge/faces", "faces left"},
    Measure{"boundary_vertices", "1", "", "/judge/boundary_vertices", "vertices on the boundary"},
    Measure{"euler", "1", "", "/judge/euler", "V - E + F - T"},
    Measure{"components", "1", "", "/judge/components", "parts that are joined by faces"},
    Measure{"volume", "unit^3", "", "/judge/volume", "sum of the tets' volumes"},
    Measure{"volume_drift_relative", "1", "lower", "/judge/volume_drift_relative",
            "change of volume over the input's volume"},
    Measure{"inverted_tets", "1", "lower", "/judge/inverted_tets", "tets of negative orientation"},
    Measure{"flat_tets", "1", "lower", "/judge/flat_tets", "tets of no volume"},
    Measure{"duplicate_tets", "1", "lower", "/judge/duplicate_tets", "tets that are there twice"},
    Measure{"nonmanifold_faces", "1", "lower", "/judge/nonmanifold_faces", "faces of more than two tets"},
    Measure{"folded_faces", "1", "lower", "/judge/folded_faces", "faces with two tets on one side"},
    Measure{"nonmanifold_edges", "1", "lower", "/judge/nonmanifold_edges", "edges with a broken link"},
    Measure{"nonmanifold_vertices", "1", "lower", "/judge/nonmanifold_vertices",
            "vertices with a broken link"},
    Measure{"isolated_vertices", "1", "lower", "/judge/isolated_vertices", "vertices without a tet"},
    Measure{"boundary_changed_faces", "1", "lower", "/judge/boundary_changed_faces",
            "boundary faces that are not the input's, to the bit"},
    Measure{"kept_tets", "1", "", "/judge/kept_tets", "tets of the input that meet a region to keep"},
    Measure{"kept_tets_changed", "1", "lower", "/judge/kept_tets_changed",
            "of these, tets that are not in the output, to the bit"},
    Measure{"region_tets", "1", "", "/judge/region_tets", "tets that meet a region of the plan"},
    Measure{"surface_distance_lower", "unit", "lower", "/judge/surface_distance_lower",
            "two-sided Hausdorff distance from the input's boundary: no less than this"},
    Measure{"surface_distance_upper", "unit", "lower", "/judge/surface_distance_upper",
            "two-sided Hausdorff distance from the input's boundary: no more than this"},
    Measure{"surface_distance_relative", "1", "lower", "/judge/surface_distance_relative",
            "surface_distance_upper over the diagonal of the box around both boundaries"},
    Measure{"mean_surface_distance", "unit", "lower", "/judge/mean_surface_distance",
            "mean distance of the boundaries, by area, the greater of the two directions"},
    Measure{"boundary_bend_ratio", "1", "lower", "/judge/boundary_bend_ratio",
            "sum over the boundary's edges of length times angle between the normals, over the input's"},
    Measure{"feature_edges", "1", "", "/judge/feature_edges",
            "edges of the input's skin that are sharper than the plan's feature_deg"},
    Measure{"feature_distance_lower", "unit", "lower", "/judge/feature_distance_lower",
            "greatest distance from these edges to the output's that are sharper than half of it: no less "
            "than this"},
    Measure{"feature_distance_upper", "unit", "lower", "/judge/feature_distance_upper",
            "the same: no more than this"},
    Measure{"surface_self_intersections", "1", "lower", "/judge/surface_self_intersections",
            "pairs of boundary faces that meet where they share nothing"},
    Measure{"euler_unchanged", "0 or 1", "higher", "/judge/euler_unchanged",
            "1 if the Euler characteristic is the input's"},
    Measure{"components_unchanged", "0 or 1", "higher", "/judge/components_unchanged",
            "1 if there are as many parts as in the input"},
    Measure{"displacement_l2", "1", "lower", "/judge/displacement_l2",
            "relative L2 error of the displacement at the scene's vertices, weighted by volume"},
    Measure{"displacement_deformation", "1", "lower", "/judge/displacement_deformation",
            "the same after the best rigid motion is taken off error and reference"},
    Measure{"displacement_max", "1", "lower", "/judge/displacement_max",
            "largest error of a displacement over the largest displacement"},
    Measure{"displacement_energy", "1", "lower", "/judge/displacement_energy",
            "relative error of the displacement in the norm of linear elasticity's energy"},
    Measure{"displacement_energy_whole", "1", "lower", "/judge/displacement_energy_whole",
            "the same with what happens between the vertices: quadratic in each tet"},
    Measure{"displacement_l2_at", "1", "lower", "/judge/displacement_l2_at",
            "relative L2 error where the scene asks for its error (require.error.at)"},
    Measure{"displacement_deformation_at", "1", "lower", "/judge/displacement_deformation_at",
            "the same after the whole body's best rigid motion is taken off error and reference"},
    Measure{"displacement_max_at", "1", "lower", "/judge/displacement_max_at",
            "largest error there over the largest displacement there"},
    Measure{"pad_force", "1", "lower", "/judge/pad_force",
            "relative error of the force of the pads that move"},
    Measure{"rigid_share", "1", "", "/judge/rigid_share",
            "share of the reference's mean square displacement that a rigid motion has"},
    Measure{"stiffness_share_springs", "1", "", "/report/stiffness_share_springs",
            "share of the answer's elastic energy that springs hold, of methods with springs"},
    Measure{"solution_l2", "1", "lower", "/judge/solution_l2",
            "relative L2 error against a known solution, integrated over the body"},
    Measure{"solution_max", "1", "lower", "/judge/solution_max",
            "largest error against a known solution over its largest displacement"},
    Measure{"solution_order", "1", "higher", "/judge/solution_order",
            "order at which the error falls from the next coarser mesh to this one"},
    Measure{"value_error", "1", "lower", "/judge/value_error", "relative error of a value that is known"},
    Measure{"max_displacement_m", "m", "", "/judge/max_displacement_m", "largest displacement of a vertex"},
    Measure{"reference_error", "1", "lower", "/judge/reference_error",
            "estimated relative L2 error of the reference"},
    Measure{"reference_ratio", "1", "higher", "/judge/reference_ratio",
            "displacement_l2 over reference_error: below 5 the reference is too coarse to judge"},
    Measure{"reference_too_coarse", "0 or 1", "lower", "/judge/reference_too_coarse",
            "1 if the reference is not 5 times better than what it judges"},
    Measure{"points_outside", "1", "lower", "/judge/points_outside",
            "vertices of the scene outside the simplified mesh that was solved on"},
    Measure{"frequency_first", "1", "lower", "/judge/frequency_first",
            "relative error of the lowest natural frequency"},
    Measure{"frequency_mean", "1", "lower", "/judge/frequency_mean",
            "mean size of the relative errors of the first ten natural frequencies"},
    Measure{"frequency_worst", "1", "lower", "/judge/frequency_worst",
            "largest relative error of the first ten natural frequencies"},
    Measure{"probe_l2", "1", "lower", "/judge/probe_l2",
            "relative L2 error of the probes' displacement over the whole history"},
    Measure{"force_l2", "1", "lower", "/judge/force_l2",
            "relative L2 error of the tool's force over the time that it is there"},
    Measure{"solver_probe_l2", "1", "lower", "/judge/solver_probe_l2",
            "the same against the motion that the solver would come to if it left nothing (own_limit)"},
    Measure{"solver_force_l2", "1", "lower", "/judge/solver_force_l2",
            "relative L2 distance of the tool's force from that motion's"},
    Measure{"amplitude_error", "1", "", "/judge/amplitude_error",
            "amplitude of the probe's oscillation over the reference's, less 1"},
    Measure{"phase_error_deg", "deg", "", "/judge/phase_error_deg",
            "phase of the probe's oscillation less the reference's, where the window starts"},
    Measure{"oscillation_error", "1", "", "/judge/oscillation_error",
            "frequency of the probe's oscillation over the reference's, less 1"},
    Measure{"decay_error", "1", "", "/judge/decay_error",
            "decay rate of the probe's oscillation over the reference's, less 1"},
    Measure{"damping_ratio_error", "1", "", "/judge/damping_ratio_error",
            "damping ratio of the probe's oscillation less the reference's"},
    Measure{"unexplained", "1", "", "/judge/unexplained",
            "what the fitted oscillations leave over of the probe's motion, rms over rms"},
    Measure{"steps", "1", "lower", "/report/steps", "time steps taken"},
    Measure{"identify_s", "s", "lower", "/report/identify_s", "time to identify the model's constants"},
    Measure{"solve_s", "s", "lower", "/report/solve_s",
            "time to solve for the displacement, or to take the steps"},
    Measure{"product_s", "s", "lower", "/report/product_s",
            "time of one product with the stiffness, median, outside the kernel"},
    Measure{"answer_s", "s", "lower", "/report/answer_s",
            "time of a displacement from a new load with all that is prepared (back-substitution), median, "
            "outside the kernel"},
    Measure{"explicit_step_s", "s", "higher", "/report/explicit_step_s",
            "the longest stable step of symplectic Euler, undamped, predicted"},
    Measure{"step_wall_s", "s", "lower", "/report/step_wall_s",
            "time that such a step takes on the fastest engine, median, outside the kernel"},
    Measure{"simulated_second_s", "s", "lower", "/report/simulated_second_s",
            "time for a simulated second of steps of nine tenths of explicit_step_s, outside the kernel; by "
            "modes, of exact steps of a millisecond and sixty displacements of all vertices"},
    Measure{"simplify_s", "s", "lower", "/solved_on/simplify_s",
            "time that the simplifier took for the mesh that was solved on"},
    Measure{"stiffness_entries", "1", "lower", "/report/stiffness_entries",
            "numbers of the stiffness, both halves: multiplications of one product"},
    Measure{"factor_entries", "1", "lower", "/report/factor_entries", "numbers of its factor"},
    Measure{"unknowns", "1", "lower", "/report/unknowns", "free components that are solved for"},
    Measure{"iterations", "1", "lower", "/report/iterations", "iterations that the method reports"},
    Measure{"energy_j", "J", "", "/report/energy_j",
            "elastic energy of the body that the method reports, without its supports"},
    Measure{"zero_springs", "1", "lower", "/report/zero_springs", "springs without stiffness"},
    Measure{"kkt_relative", "1", "lower", "/report/kkt_relative",
            "residual of the optimality conditions of the identification"},
    Measure{"predicted_step_s", "s", "", "/reported/predicted_step_s", "longest stable step, predicted"},
    Measure{"measured_step_s", "s", "", "/judge/measured_step_s", "longest stable step, measured"},
    Measure{"measured_over_predicted", "1", "", "/judge/measured_over_predicted",
            "longest stable step, measured over predicted"},
    Measure{"row_sum_over_measured", "1", "higher", "/judge/row_sum_over_measured",
            "step bound by row sums over the measured one"},
    Measure{"stiffness_ratio_mean", "1", "", "/report/stiffness_ratio_mean",
            "mean over the vertices of sum k U^2 / (12 E V)"},
    Measure{"return_error", "1", "lower", "/judge/return_error",
            "largest displacement left when a body that was let go is next touched, over that when it was "
            "let go: the "
            "worst of its returns"},
    Measure{"return_rms_error", "1", "lower", "/judge/return_rms_error",
            "the same of the root mean square over the vertices"},
    Measure{"half_return_s", "s", "lower", "/judge/half_return_s",
            "time until at most a half of the displacement is left, the longest of the returns"},
    Measure{"twentieth_return_s", "s", "lower", "/judge/twentieth_return_s",
            "time until at most a twentieth is left"},
    Measure{"peak_speed_m_s", "m/s", "", "/reported/peak_speed_m_s", "largest speed of a vertex"},
    Measure{"speeds_cut", "1", "lower", "/reported/speeds_cut",
            "vertices times steps whose speed was cut to the limit"},
    Measure{"inverted_tets_most", "1", "lower", "/reported/inverted_tets_most",
            "inverted tetrahedra at the worst observed time"},
    Measure{"real_time_factor", "1", "higher", "/reported/real_time_factor",
            "simulated time over the time of the steps"},
    Measure{"tick_real_time_factor", "1", "higher", "/reported/tick_real_time_factor",
            "the same with one step a tick of 5 ms, as the thesis's timer has it"},
    Measure{"stable_step_s", "s", "higher", "/reported/stable_step_s",
            "longest stable step of the body at rest"},
    Measure{"stability_margin", "1", "higher", "/reported/stability_margin",
            "stable_step_s over the step taken"},
    Measure{"slowest_decay_s", "s", "lower", "/judge/slowest_decay_s",
            "time in which the slowest motion of the body at rest falls to 1/e"},
    Measure{"steps_per_tick", "1", "lower", "/reported/steps_per_tick", "steps of the engine in a tick"},
    Measure{"tick_p50_s", "s", "lower", "/reported/tick_p50_s", "time of a tick, median"},
    Measure{"tick_p99_s", "s", "lower", "/reported/tick_p99_s", "time that 99% of the ticks do not exceed"},
    Measure{"tick_p99_9_s", "s", "lower", "/reported/tick_p99_9_s",
            "time that 99.9% of the ticks do not exceed"},
    Measure{"tick_worst_s", "s", "lower", "/reported/tick_worst_s", "time of the worst tick"},
    Measure{"ticks", "1", "", "/reported/ticks", "ticks that were timed"},
    Measure{"ticks_missed", "1", "lower", "/reported/ticks_missed", "ticks longer than their deadline"},
    Measure{"setup_s", "s", "lower", "/reported/setup_s",
            "time from the task to the first tick: model, tables, factors that are made beforehand"},
    Measure{"first_tick_s", "s", "lower", "/reported/first_tick_s",
            "time of the first tick, which is not among those above: implicit integrators factor in it"},
    Measure{"residual_worst", "1", "lower", "/reported/residual_worst",
            "largest share of the forces out of balance that a solver left in a step, where measured"},
    Measure{"held_force_size_n", "N", "", "/judge/held_force_size_n",
            "force of the tool on the body that it holds"},
    Measure{"reference_force_size_n", "N", "", "/judge/reference_force_size_n",
            "the same of the finite elements"},
    Measure{"reference_force_change", "1", "", "/judge/reference_force_change",
            "change of the finite elements' force by their last refinement, relative"},
    Measure{"force_error", "1", "lower", "/judge/force_error",
            "difference of the two forces over the size of the finite elements'"},
};

}  // namespace

std::span<const Measure> list_measures() {
  return kMeasures;
}

std::vector<std::string> measure_names() {
  std::vector<std::string> names;
  names.reserve(kMeasures.size());
  for (const Measure& measure : kMeasures) names.emplace_back(measure.name);
  return names;
}

const Measure* find_measure(const std::string& name) {
  for (const Measure& measure : kMeasures) {
    if (name == measure.name) return &measure;
  }
  return nullptr;
}

bool is_measured_anew(const Measure& measure) {
  const std::string_view key = measure.key;
  for (const char* start : {"/kernel_s", "/wall_s", "/user_s", "/peak_rss_bytes", "/report/identify_s",
                            "/report/solve_s", "/report/product_s", "/report/answer_s", "/report/step_wall_s",
                            "/report/simulated_second_s", "/solved_on/simplify_s", "/reported/tick",
                            "/reported/setup_s", "/reported/first_tick_s", "/reported/real_time_factor"}) {
    if (key.starts_with(start)) return true;
  }
  return false;
}

bool is_clock_time(const Measure& measure) {
  return is_measured_anew(measure) && std::string_view(measure.unit) == "s";
}

std::optional<double> figure_of(const nlohmann::json& record, const Measure& measure) {
  const nlohmann::json::json_pointer pointer(measure.key);
  if (!record.contains(pointer)) return std::nullopt;
  const nlohmann::json& value = record.at(pointer);
  if (value.is_boolean()) return value.get<bool>() ? 1.0 : 0.0;
  if (!value.is_number()) return std::nullopt;
  const auto figure = value.get<double>();
  return std::isfinite(figure) ? std::optional<double>(figure) : std::nullopt;
}

}  // namespace palpate::experiments

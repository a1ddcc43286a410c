#include "reference/mixed_order/modes_run.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/dynamics/linear_algebra/vertex_field.h"
#include "core/dynamics/enriched/enriched_elements.h"
#include "core/mesh/topology.h"
#include "reference/linear_systems/answer_cost.h"
#include "reference/linear_systems/factor.h"
#include "reference/mixed_order/error_modes.h"
#include "reference/mixed_order/order_options.h"

namespace palpate::reference {
namespace {

using dynamics::EnrichedElements;
using dynamics::HeldElements;
using nlohmann::json;

/// Far from the seeds of training.
constexpr std::uint64_t kValidationSeed = 500'000'000'003;

struct ModesRunOptions {
  TrainingOptions training;
  int refine = 0;
  std::size_t validate = 20;
  CommonOptions common;
};

ModesRunOptions take_modes_options(const Request& request) {
  json left = request.options;
  ModesRunOptions options;
  const auto take_count = [&](const char* key, std::int64_t least, std::int64_t most, std::size_t fallback) {
    return static_cast<std::size_t>(take_whole(left, key, least, most, static_cast<std::int64_t>(fallback)));
  };
  TrainingOptions& training = options.training;
  training.modes = take_count("modes", 0, 2000, training.modes);
  training.samples = take_count("samples", 1, 10000, training.samples);
  training.holdings = take_count("holdings", 0, 100, training.holdings);
  training.seed = take_count("seed", 0, 1'000'000, training.seed);
  training.least_radius = take_number(left, "least_radius", 0.1, 4.0, training.least_radius);
  options.refine = static_cast<int>(take_whole(left, "refine", 0, 1, 0));
  options.validate = take_count("validate", 0, 1000, options.validate);
  options.common = take_common_options(left);
  require_all_taken(left);
  return options;
}

/// The scene's own system, with and without modes.
struct PreparedModes {
  TrainingBody training;
  TrainingSystem system;
  std::unique_ptr<HeldElements> coarse;
  std::unique_ptr<EnrichedElements> enriched;
  std::vector<Vec3> held_by_m;  ///< of the linear functions
};

/// Learns, then makes the system of the scene.
std::unique_ptr<PreparedModes> prepare_modes(const DeformTask& task, const ModesRunOptions& options,
                                             const dynamics::FactorMaker& make_factor) {
  auto out = std::make_unique<PreparedModes>();
  out->training = build_training_body(task.mesh, task.problem, options.refine);
  const TrainingBody& training = out->training;
  const dynamics::PrincipalFields modes = learn_error_modes(training, options.training, make_factor);
  out->system = build_training_system(
      training, build_element_matrices(training.fine.mesh, training.fine.space, task.problem.material),
      task.problem);
  const TrainingSystem& system = out->system;
  out->coarse =
      std::make_unique<HeldElements>(system.coarse, system.coarse.stiffness, system.coarse_held, make_factor);
  out->enriched =
      std::make_unique<EnrichedElements>(*out->coarse, training.fine.map, system.whole, modes.fields);
  for (const Index node : training.fine.map.nodes) out->held_by_m.push_back(system.loads.held_by_m[node]);
  return out;
}

/// How far both are from the quadratic elements under loads that are drawn anew, on the scene's holding.
Validation validate_modes(const PreparedModes& prepared, const ModesRunOptions& options,
                          const dynamics::FactorMaker& make_factor) {
  const TrainingBody& training = prepared.training;
  const TrainingSystem& system = prepared.system;
  const HeldElements fine(system.body, system.whole, system.held, make_factor);
  const EnrichedElements linear(*prepared.coarse, training.fine.map, system.whole, {});
  const Deformation deformation(training.organ);
  const std::vector<Triangle> skin = build_boundary(training.organ);
  const std::vector<Vec3> nothing(system.held.size());
  const std::vector<Vec3> coarse_nothing(system.coarse_held.size());
  const auto at_vertices = [&](std::vector<Vec3> field) {
    field.resize(training.organ.points.size());
    deformation.take_off_rigid(field);
    return field;
  };
  const auto off_sq = [&](const std::vector<Vec3>& truth, std::vector<Vec3> found) {
    dynamics::add_scaled(found, -1.0, truth);
    return deformation.product(found, found) / deformation.product(truth, truth);
  };
  Validation out;
  for (std::size_t n = 0; n < options.validate; ++n) {
    BoundaryProblem load =
        draw_load(training.organ, skin,
                  {kValidationSeed + options.training.seed * 10'007 + n, options.training.least_radius});
    if (training.refine > 0) load = refine_problem(load, training.organ, training.fine.mesh);
    const std::vector<Vec3> force =
        build_node_loads(training.fine.mesh, training.fine.space, load, dynamics::BodyForces::kLeaveOut)
            .force_n;
    const std::vector<Vec3> truth = at_vertices(fine.rest_under(force, nothing));
    const double linear_sq = off_sq(truth, at_vertices(linear.rest_under(force, coarse_nothing)));
    const double enriched_sq =
        off_sq(truth, at_vertices(prepared.enriched->rest_under(force, coarse_nothing)));
    const auto count = static_cast<double>(options.validate);
    out.linear += linear_sq / count;
    out.enriched += enriched_sq / count;
    out.enriched_worst = std::max(out.enriched_worst, std::sqrt(enriched_sq));
  }
  out.linear = std::sqrt(out.linear);
  out.enriched = std::sqrt(out.enriched);
  return out;
}

SolidFigures measure_enriched(const PreparedModes& prepared, std::span<const Vec3> force,
                              std::span<const Vec3> all, std::size_t supports) {
  const TrainingSystem& system = prepared.system;
  SolidFigures figures;
  std::vector<Vec3> pull(all.size());
  multiply(system.body.stiffness, all, pull);
  figures.energy_j = 0.5 * dynamics::dot_of(all, pull);
  dynamics::SupportFigures held = measure_supports(system.loads, 2, all, supports);
  figures.potential_j = figures.energy_j + held.energy_j - dynamics::dot_of(system.loads.force_n, all);
  figures.support_forces_n = std::move(held.forces_n);
  // Out of balance in the space that was solved in: along the linear functions, and along the modes.
  multiply(system.whole, all, pull);
  for (std::size_t i = 0; i < pull.size(); ++i) pull[i] = force[i] - pull[i];
  const dynamics::NodeMap& map = prepared.training.fine.map;
  std::vector<Vec3> left = apply_transposed(map, pull);
  std::vector<Vec3> reactions = left;
  dynamics::clear_held(system.coarse_held, left);
  dynamics::add_scaled(reactions, -1.0, left);
  const double acting = dynamics::norm_of(apply_transposed(map, force)) + dynamics::norm_of(reactions);
  figures.residual_relative = acting > 0.0 ? dynamics::norm_of(left) / acting : 0.0;
  double modes_sq = 0.0;
  double energy_norm_sq = 0.0;
  for (const std::vector<Vec3>& z : prepared.enriched->fields()) {
    const double along = dynamics::dot_of(z, pull);
    const double whole = dynamics::dot_of(z, force);
    modes_sq += along * along;
    energy_norm_sq += whole * whole;
  }
  if (energy_norm_sq > 0.0)
    figures.residual_relative = std::max(figures.residual_relative, std::sqrt(modes_sq / energy_norm_sq));
  return figures;
}

/// A back-substitution of linear elements, the modes' shares of a load, and the modes at the vertices.
AnswerCost measure_modes_cost(const PreparedModes& prepared, std::span<const Vec3> force) {
  const std::size_t vertices = prepared.training.organ.points.size();
  const std::vector<std::vector<Vec3>>& fields = prepared.enriched->fields();
  AnswerCost cost =
      measure_cost(prepared.coarse->stiffness(), prepared.coarse->factor(), prepared.coarse->unknowns());
  std::vector<Vec3> table;  // the modes at the vertices, one after the other
  std::vector<std::size_t> loaded;
  for (std::size_t i = 0; i < force.size(); ++i) {
    if (length_sq(force[i]) > 0.0) loaded.push_back(i);
  }
  for (const std::vector<Vec3>& z : fields)
    table.insert(table.end(), z.begin(), z.begin() + static_cast<std::ptrdiff_t>(vertices));
  std::vector<Vec3> out(vertices);
  cost.answer_s += median_seconds([&] {
    for (std::size_t m = 0; m < fields.size(); ++m) {
      double share = 0.0;
      for (const std::size_t i : loaded) share += dot(fields[m][i], force[i]);
      dynamics::add_scaled(out, share, {table.data() + m * vertices, vertices});
    }
  });
  cost.unknowns += fields.size();
  cost.stiffness_entries += 3 * vertices * fields.size();
  cost.factor_entries += 3 * vertices * fields.size();
  return cost;
}

}  // namespace

Response run_modes(const Request& request) {
  const ModesRunOptions options = take_modes_options(request);
  const DeformTask task = read_small_task(request);
  const dynamics::FactorMaker make_factor = choose_factor(options.common.factor);
  Response response;
  json& report = response.report;
  report = {{"method", request.method}};

  const Stopwatch kernel;
  const std::unique_ptr<PreparedModes> prepared = prepare_modes(task, options, make_factor);
  report["identify_s"] = kernel.seconds();
  const Stopwatch solving;
  const std::vector<Vec3> force = sum_forces(prepared->system.loads, 2);
  std::vector<Vec3> all = prepared->enriched->rest_under(force, prepared->held_by_m);
  report["solve_s"] = solving.seconds();
  response.kernel_s = kernel.seconds();

  report_figures(measure_enriched(*prepared, force, all, task.problem.supports.size()), report);
  report["modes"] = prepared->enriched->fields().size();
  if (options.validate > 0) {
    const Validation found = validate_modes(*prepared, options, make_factor);
    report["validation_linear"] = found.linear;
    report["validation_enriched"] = found.enriched;
    report["validation_enriched_worst"] = found.enriched_worst;
  }
  report_cost(measure_modes_cost(*prepared, force), report);
  response.notes.emplace_back(options.training.holdings == 0
                                  ? "the modes were learnt on the scene's own supports, from other loads"
                                  : "the modes were learnt on supports and loads that were drawn");
  const std::size_t rows =
      task.mesh.points.size() + (options.common.midpoints ? build_edges(task.mesh).size() : 0);
  all.resize(rows);  // after the vertices come, at any refinement, the midpoints of the organ's edges
  write_displacement(request.output, all);
  return response;
}

}  // namespace palpate::reference

#include "experiments/training_run.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/dynamics/loads.h"
#include "core/dynamics/volume_models.h"
#include "core/mesh/medit.h"
#include "core/mesh/topology.h"
#include "core/springs/network.h"
#include "experiments/answer_cache.h"
#include "experiments/scene_problem.h"
#include "reference/deform_problem.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

constexpr double kReferenceTimeout = 7200.0;  // s
constexpr double kLeastShare = 1e-3;          // of the mean stiffness, where a spring of zero starts

/// What fields are solved with.
struct ReferenceSolver {
  MethodEntry method;
  fs::path scratch;
  int threads = 1;
};

std::vector<double> components_of(const std::vector<Vec3>& field) {
  std::vector<double> out;
  out.reserve(3 * field.size());
  for (const Vec3& v : field) out.insert(out.end(), {v.x, v.y, v.z});
  return out;
}

/// The elastic supports of a problem as stiffness, and their pull towards where they are.
void add_supports(const dynamics::Loads& loads, springs::TrainingBoundary& boundary,
                  std::vector<double>& force) {
  for (const dynamics::SupportFace& support : loads.supports) {
    const std::array<double, 3> by{support.by_m.x, support.by_m.y, support.by_m.z};
    for (const Index a : support.face)
      for (Index axis = 0; axis < 3; ++axis) {
        for (const Index b : support.face) {
          const double value = support.coefficient_n_per_m * (a == b ? 2.0 : 1.0);
          boundary.stiffness.push_back({3 * a + axis, 3 * b + axis, value});
        }
        force[3 * a + axis] += 4.0 * support.coefficient_n_per_m * by.at(axis);
      }
  }
}

bool is_same(const springs::TrainingBoundary& a, const springs::TrainingBoundary& b) {
  return a.held == b.held &&
         std::equal(a.stiffness.begin(), a.stiffness.end(), b.stiffness.begin(), b.stiffness.end(),
                    [](const springs::StiffnessEntry& p, const springs::StiffnessEntry& q) {
                      return p.row == q.row && p.column == q.column && p.value_n_per_m == q.value_n_per_m;
                    });
}

/// Adds the case; cases that are held alike share one boundary, and so one factorisation.
void add_case(const TetMesh& mesh, const BoundaryProblem& problem, const std::string& name,
              const std::vector<Vec3>& target, springs::TrainingSet& set) {
  const dynamics::Loads loads = dynamics::build_loads(mesh, problem);
  springs::TrainingCase one;
  one.name = name;
  one.force_n = components_of(loads.force_n);
  one.held_m = components_of(loads.held_by_m);
  one.target_m = components_of(target);
  springs::TrainingBoundary boundary;
  for (const std::uint8_t bits : loads.held)
    for (unsigned axis = 0; axis < 3; ++axis)
      boundary.held.push_back(static_cast<std::uint8_t>(bits >> axis & 1U));
  add_supports(loads, boundary, one.force_n);
  while (one.boundary < set.boundaries.size() && !is_same(set.boundaries[one.boundary], boundary))
    ++one.boundary;
  if (one.boundary == set.boundaries.size()) set.boundaries.push_back(std::move(boundary));
  set.cases.push_back(std::move(one));
}

/// The field of quadratic elements at the vertices of the mesh.
std::vector<Vec3> solve_field(const TetMesh& mesh, const BoundaryProblem& problem, const std::string& name,
                              int refine, const ReferenceSolver& solver, std::size_t number) {
  const fs::path folder = solver.scratch / std::to_string(number);
  fs::create_directories(folder / "answer");
  ContestantTask task;
  task.method = solver.method;
  task.mesh_in = folder / "in.mesh";
  task.problem_in = folder / "problem.json";
  write_medit(task.mesh_in, mesh);
  write_file_atomically(task.problem_in, reference::problem_to_json(problem).dump() + "\n");
  task.scratch = folder / "answer";
  task.options = resolve_options(*solver.method.method, {});
  task.options["refine"] = refine;
  task.threads = solver.threads;
  task.timeout_s = kReferenceTimeout;
  bool was_kept = false;
  const ContestantAnswer answer = run_cached(task, was_kept);
  if (answer.outcome != "ok")
    throw UnavailableError("the field of " + name + ": " + answer.outcome + ": " + answer.message);
  const std::string outcome = answer.report.at("outcome").get<std::string>();
  if (outcome != "converged") throw UnavailableError("the field of " + name + ": " + outcome);
  std::vector<Vec3> field =
      reference::read_displacement(answer.output, mesh.points.size(), build_edges(mesh).size());
  field.resize(mesh.points.size());
  return field;
}

/// The springs to start from and the dilatations, as terms with constants.
void build_start(const TrainingPlan& plan, TrainingInput& input) {
  const auto volume = plan.volume == TrainedVolume::kNone ? dynamics::VolumeModel::kNone
                                                          : dynamics::VolumeModel::kNodeAverage;
  springs::IdentifyOptions options;
  options.face_opposite = plan.face_opposite;
  springs::IdentifyReport report;
  input.network = springs::identify_springs(input.mesh, dynamics::spring_material(plan.material, volume),
                                            plan.start, options, report);
  input.notes.insert(input.notes.end(), report.warnings.begin(), report.warnings.end());
  springs::add_spring_terms(input.mesh, input.network, kLeastShare, input.terms);
  const double modulus = plan.material.lambda_pa() - plan.material.mu_pa();
  if (plan.volume == TrainedVolume::kTet) springs::add_tet_dilatation_terms(input.mesh, modulus, input.terms);
  if (plan.volume == TrainedVolume::kNodeAverage)
    springs::add_vertex_dilatation_terms(input.mesh, modulus, input.terms);
}

ReferenceSolver find_solver(const Registry& registry, const fs::path& scratch, int threads) {
  const auto method = registry.find("fem.p2");
  if (!method) throw UnavailableError("training needs the contestant fem.p2, which is not there");
  const std::string why = method->contestant->unavailable();
  if (!why.empty()) throw UnavailableError("training needs fem.p2, which is unavailable: " + why);
  return {*method, scratch, threads};
}

/// Estimates the seconds that are left from those gone by.
class StepClock {
 public:
  explicit StepClock(std::size_t steps) : steps_(steps) {}

  /// After another step.
  double seconds_left() {
    ++done_;
    const std::chrono::duration<double> gone = std::chrono::steady_clock::now() - start_;
    return gone.count() / static_cast<double>(done_) * static_cast<double>(steps_ - done_);
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::size_t steps_;
  std::size_t done_ = 0;
};

/// The errors of all cases of a set with these constants.
std::vector<double> errors_with(const springs::RankOneTerms& terms, const std::vector<double>& constant,
                                const springs::TrainingSet& set) {
  std::vector<double> errors;
  for (const springs::CaseResult& result : springs::solve_cases(terms, constant, set))
    errors.push_back(result.relative_error);
  return errors;
}

}  // namespace

double root_mean_square(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

TrainingInput build_training_input(const TrainingPlan& plan, const Registry& registry,
                                   const fs::path& scratch, int threads, Progress& progress) {
  const ReferenceSolver solver = find_solver(registry, scratch, threads);
  TrainingInput input;
  MadeMesh made = build_scene_mesh(plan.mesh);
  input.mesh = std::move(made.mesh);
  input.notes = std::move(made.notes);
  build_start(plan, input);
  std::vector<double> weight;
  for (const double volume : springs::build_influence_volumes(input.mesh))
    weight.insert(weight.end(), 3, volume);
  const std::array<const TrainingSplit*, 4> splits{&plan.train, &plan.validate, &plan.test_loads,
                                                   &plan.test_clamps};
  std::size_t all = 0;
  for (const TrainingSplit* split : splits) all += split->size();
  progress.start(all);
  StepClock clock(all);
  std::size_t number = 0;
  for (const TrainingSplit* split : splits) {
    TrainingCases cases{split->name, {weight, {}, {}}};
    for (const std::size_t clamp : split->clamps)
      for (const std::size_t load : split->loads) {
        Scene scene;
        scene.file = plan.file;
        scene.material = plan.material;
        scene.clamps = plan.clamps[clamp].clamps;
        scene.loads = plan.loads[load].loads;
        const std::string name = plan.clamps[clamp].name + "/" + plan.loads[load].name;
        progress.show("field of " + name);
        const BoundaryProblem problem = build_problem(place_scene(std::move(scene), input.mesh), input.mesh);
        add_case(input.mesh, problem, name,
                 solve_field(input.mesh, problem, name, plan.refine, solver, number++), cases.set);
        progress.step(clock.seconds_left());
      }
    input.splits.push_back(std::move(cases));
  }
  return input;
}

TrainingOutcome run_training(const TrainingInput& input, const TrainingPlan& plan, Progress& progress) {
  TrainingOutcome outcome;
  progress.start(plan.ridges.size());
  StepClock clock(plan.ridges.size());
  for (const double ridge : plan.ridges) {
    progress.show("fit with ridge " + short_number(ridge));
    springs::TrainingOptions options;
    options.ridge = ridge;
    options.lbfgs.max_iterations = plan.iterations;
    const springs::TrainingReport report = springs::fit_constants(input.terms, input.splits[0].set, options);
    RidgeResult result{ridge, report.error_after, 0.0, report.lbfgs};
    result.validate_rms = root_mean_square(errors_with(input.terms, report.constant, input.splits[1].set));
    if (outcome.ridges.empty() || result.validate_rms < outcome.ridges[outcome.chosen].validate_rms) {
      outcome.chosen = outcome.ridges.size();
      outcome.constant = report.constant;
    }
    progress.say("ridge " + short_number(ridge) + ": train " + short_number(100.0 * result.train_rms) +
                 "%, validate " + short_number(100.0 * result.validate_rms) + "%");
    outcome.ridges.push_back(result);
    progress.step(clock.seconds_left());
  }
  for (const TrainingCases& split : input.splits) {
    SplitErrors errors{split.name, {}, {}, {}};
    for (const springs::TrainingCase& one : split.set.cases) errors.cases.push_back(one.name);
    errors.before = errors_with(input.terms, input.terms.constant, split.set);
    errors.after = errors_with(input.terms, outcome.constant, split.set);
    outcome.errors.push_back(std::move(errors));
  }
  return outcome;
}

}  // namespace palpate::experiments

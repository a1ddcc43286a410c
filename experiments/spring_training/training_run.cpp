#include "experiments/spring_training/training_run.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/base/stopwatch.h"
#include "core/dynamics/elasticity/loads.h"
#include "core/dynamics/elasticity/volume_models.h"
#include "core/dynamics/statics/calibration.h"
#include "core/mesh/topology.h"
#include "core/springs/network/network.h"
#include "experiments/contestants/solution.h"
#include "experiments/files/problem_folder.h"
#include "experiments/scene_reader/scene_problem.h"
#include "reference/door/deform_problem.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

constexpr double kReferenceTimeout = 7200.0;  // s
constexpr double kLeastShare = 1e-3;          // of the mean stiffness, where a spring of zero starts
constexpr double kLeastModulus = 0.02;        // of mu, where a dilatation of zero starts

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

/// One problem on the plan's mesh.
struct ProblemOnMesh {
  const TetMesh& mesh;
  std::string name;
  ProblemPaths files;
};

/// The field of finite elements at the vertices of the mesh.
std::vector<Vec3> solve_field(const ProblemOnMesh& on, const std::string& method, int refine,
                              const TrainingSetting& setting) {
  ContestantTask task;
  task.method = *setting.registry.find(method);
  task.mesh_in = on.files.mesh;
  task.problem_in = on.files.problem;
  task.scratch = on.files.mesh.parent_path() / method;
  fs::create_directories(task.scratch);
  task.options = resolve_options(*task.method.method, {});
  task.options["refine"] = refine;
  task.threads = setting.threads;
  task.timeout_s = kReferenceTimeout;
  task.stop_flag = setting.stop_flag;
  const Solution solution = solve(task, "converged");
  if (solution.interrupted) throw TrainingInterrupted();
  if (!solution.failure.empty())
    throw UnavailableError(method + " on the training case " + on.name + " " + solution.failure);
  const std::size_t vertices = on.mesh.points.size();
  std::vector<Vec3> field =
      reference::read_displacement(solution.answer.output, vertices, build_edges(on.mesh).size());
  field.resize(vertices);
  return field;
}

double relative_error(const std::vector<double>& weight, const std::vector<double>& u,
                      const std::vector<double>& target) {
  double difference = 0.0;
  double size = 0.0;
  for (std::size_t i = 0; i < weight.size(); ++i) {
    difference += weight[i] * (u[i] - target[i]) * (u[i] - target[i]);
    size += weight[i] * target[i] * target[i];
  }
  return std::sqrt(difference / size);
}

void require_elements(const Registry& registry) {
  for (const char* name : {"fem.p2", "fem.p1"}) {
    const auto method = registry.find(name);
    if (!method)
      throw UnavailableError(std::string("training needs the contestant ") + name + ", which is not there");
    const std::string why = method->contestant->unavailable();
    if (!why.empty())
      throw UnavailableError(std::string("training needs ") + name + ", which is unavailable: " + why);
  }
}

/// Estimates the seconds that are left from those gone by.
class StepClock {
 public:
  explicit StepClock(std::size_t steps) : steps_(steps) {}

  /// After another step.
  double seconds_left() {
    ++done_;
    return watch_.seconds() / static_cast<double>(done_) * static_cast<double>(steps_ - done_);
  }

 private:
  Stopwatch watch_;
  std::size_t steps_;
  std::size_t done_ = 0;
};

/// Throws when the run is to be given up.
void check_stop(const TrainingSetting& setting) {
  if (setting.stop_flag != nullptr && *setting.stop_flag != 0) throw TrainingInterrupted();
}

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

BoundaryProblem place_case(const TrainingPlan& plan, std::size_t clamp, std::size_t load,
                           const TetMesh& mesh) {
  Scene scene;
  scene.file = plan.file;
  scene.material = plan.material;
  scene.clamps = plan.clamps[clamp].clamps;
  scene.loads = plan.loads[load].loads;
  return build_problem(place_scene(std::move(scene), mesh), mesh);
}

SpringStart build_spring_start(const TetMesh& mesh, const TrainingPlan& plan, bool face_opposite,
                               bool calibrated, std::vector<std::string>& notes) {
  const auto volume = plan.volume == TrainedVolume::kNone ? dynamics::VolumeModel::kNone
                                                          : dynamics::VolumeModel::kNodeAverage;
  const Material material = dynamics::spring_material(plan.material, volume);
  springs::IdentifyOptions options;
  options.face_opposite = face_opposite;
  springs::IdentifyReport report;
  SpringStart start;
  start.network = springs::identify_springs(mesh, material, plan.start, options, report);
  notes.insert(notes.end(), report.warnings.begin(), report.warnings.end());
  if (calibrated) {
    const dynamics::ElasticModel model{mesh.points, start.network, true, {}, {}};
    const double factor =
        dynamics::calibration_factor(dynamics::measure_moduli(mesh, model, {}), material.mu_pa());
    for (double& stiffness : start.network.stiffness_n_per_m) stiffness *= factor;
  }
  springs::add_spring_terms(mesh, start.network, kLeastShare, start.terms);
  // At Poisson's ratio 1/4 the start would be zero, which has no logarithm.
  const double modulus =
      std::max(plan.material.lambda_pa() - plan.material.mu_pa(), kLeastModulus * plan.material.mu_pa());
  if (plan.volume == TrainedVolume::kTet) springs::add_tet_dilatation_terms(mesh, modulus, start.terms);
  if (plan.volume == TrainedVolume::kNodeAverage)
    springs::add_vertex_dilatation_terms(mesh, modulus, start.terms);
  return start;
}

TrainingInput build_training_input(const TrainingPlan& plan, const TrainingSetting& setting) {
  require_elements(setting.registry);
  TrainingInput input;
  MadeMesh made = build_scene_mesh(plan.mesh);
  input.mesh = std::move(made.mesh);
  input.notes = std::move(made.notes);
  input.start = build_spring_start(input.mesh, plan, plan.face_opposite, plan.calibrate, input.notes);
  std::vector<double> weight;
  for (const double volume : springs::build_influence_volumes(input.mesh))
    weight.insert(weight.end(), 3, volume);
  struct Place {
    std::size_t split;
    std::string name;
    BoundaryProblem problem;
  };
  std::vector<Place> places;  // all problems first: what is wrong with one is said before hours of solving
  const std::array<const TrainingSplit*, 4> splits{&plan.train, &plan.validate, &plan.test_loads,
                                                   &plan.test_clamps};
  for (const TrainingSplit* split : splits) {
    for (const TrainingPair& pair : split->cases)
      places.push_back({input.splits.size(), plan.clamps[pair.clamp].name + "/" + plan.loads[pair.load].name,
                        place_case(plan, pair.clamp, pair.load, input.mesh)});
    input.splits.push_back({split->name, {weight, {}, {}}, {}});
  }
  setting.progress.start(places.size());
  StepClock clock(places.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Place& place = places[i];
    setting.progress.show("field of " + place.name);
    const fs::path folder = setting.scratch / std::to_string(i);
    const ProblemOnMesh on{
        input.mesh, place.name,
        write_problem_folder(input.mesh, reference::problem_to_json(place.problem), folder)};
    TrainingCases& cases = input.splits[place.split];
    add_case(input.mesh, place.problem, place.name, solve_field(on, "fem.p2", plan.refine, setting),
             cases.set);
    cases.linear_elements.push_back(relative_error(
        weight, components_of(solve_field(on, "fem.p1", 0, setting)), cases.set.cases.back().target_m));
    fs::remove_all(folder);
    setting.progress.step(clock.seconds_left());
  }
  return input;
}

TrainingOutcome run_training(const TrainingInput& input, const TrainingPlan& plan,
                             const TrainingSetting& setting) {
  TrainingOutcome outcome;
  outcome.start_validate_rms =
      root_mean_square(errors_with(input.start.terms, input.start.terms.constant, input.splits[1].set));
  Progress& progress = setting.progress;
  progress.start(plan.ridges.size());
  StepClock clock(plan.ridges.size());
  for (const double ridge : plan.ridges) {
    progress.show("fit with ridge " + short_number(ridge));
    springs::TrainingOptions options;
    options.ridge = ridge;
    options.lbfgs.max_iterations = plan.iterations;
    options.before_evaluation = [&] { check_stop(setting); };
    const springs::TrainingReport report =
        springs::fit_constants(input.start.terms, input.splits[0].set, options);
    RidgeResult result{ridge, report.error_after, 0.0, report.lbfgs};
    result.validate_rms =
        root_mean_square(errors_with(input.start.terms, report.constant, input.splits[1].set));
    if (outcome.ridges.empty() || result.validate_rms < outcome.ridges[outcome.chosen].validate_rms) {
      outcome.chosen = outcome.ridges.size();
      outcome.constant = report.constant;
    }
    progress.say("ridge " + short_number(ridge) + ": train " + short_number(100.0 * result.train_rms) +
                 "%, validate " + short_number(100.0 * result.validate_rms) + "%");
    outcome.ridges.push_back(result);
    progress.step(clock.seconds_left());
  }
  outcome.start_is_kept = outcome.start_validate_rms <= outcome.ridges[outcome.chosen].validate_rms;
  if (outcome.start_is_kept) outcome.constant = input.start.terms.constant;
  std::vector<std::string> ignored;
  const SpringStart opposite = build_spring_start(input.mesh, plan, true, true, ignored);
  outcome.models = {"start", "calibrated_opposite", "fem_p1", "trained"};
  for (const TrainingCases& split : input.splits) {
    SplitErrors errors{split.name, {}, {}};
    for (const springs::TrainingCase& one : split.set.cases) errors.cases.push_back(one.name);
    errors.of_model = {errors_with(input.start.terms, input.start.terms.constant, split.set),
                       errors_with(opposite.terms, opposite.terms.constant, split.set), split.linear_elements,
                       errors_with(input.start.terms, outcome.constant, split.set)};
    outcome.errors.push_back(std::move(errors));
  }
  return outcome;
}

}  // namespace palpate::experiments

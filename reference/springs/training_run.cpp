#include "reference/springs/training_run.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/base/stopwatch.h"
#include "core/dynamics/elasticity/volume_models.h"
#include "core/mesh/io/medit.h"
#include "core/springs/identification/identify.h"
#include "core/springs/network/moduli_csv.h"
#include "core/springs/network/springs_csv.h"
#include "reference/springs/identify_run.h"
#include "reference/springs/training_cases.h"

namespace palpate::reference {
namespace {

using nlohmann::json;

constexpr double kLeastShare = 1e-3;    // of the mean stiffness, where a spring of zero starts
constexpr double kLeastModulus = 0.02;  // of mu, where a dilatation of zero starts
constexpr std::size_t kTrainSplit = 0;
constexpr std::size_t kValidateSplit = 1;

/// What carries the dilatation beside the springs; both have trained moduli.
enum class TrainedVolume { kNone, kTet, kNodeAverage };

struct TrainingWish {
  Material material;
  springs::SpringMethod start = springs::SpringMethod::kIsotropyPatch;
  bool face_opposite = false;
  bool calibrate = false;
  TrainedVolume volume = TrainedVolume::kNone;
  std::vector<double> ridges;
  std::size_t iterations = 0;
};

/// Spring constants, and moduli where there is a volume model, as terms.
struct SpringStart {
  SpringNetwork network;
  springs::RankOneTerms terms;  ///< the springs, then the dilatations
};

struct RidgeResult {
  double ridge = 0.0;
  double train_rms = 0.0;
  double validate_rms = 0.0;
  springs::LbfgsReport lbfgs;
};

struct TrainingFits {
  std::vector<RidgeResult> ridges;
  std::size_t chosen = 0;  ///< the ridge of the least validation error
  double start_validate_rms = 0.0;
  bool start_is_kept = false;    ///< on the validation set no fit is better than the start
  std::vector<double> constant;  ///< of the chosen ridge, or of the start where that is kept
};

void tell(const json& line) {
  std::cout << line.dump(-1, ' ', false, json::error_handler_t::replace) << std::endl;
}

TrainedVolume parse_trained_volume(const std::string& name) {
  if (name == "none") return TrainedVolume::kNone;
  if (name == "tet") return TrainedVolume::kTet;
  if (name == "node_average") return TrainedVolume::kNodeAverage;
  throw InputError("volume", 0, "none, tet or node_average", name);
}

TrainingWish read_wish(const Request& request) {
  const json& options = request.options;
  return {material_of(request),
          springs::parse_spring_method(request.method),
          options.at("face_opposite").get<bool>(),
          options.at("calibrate").get<bool>(),
          parse_trained_volume(options.at("volume").get<std::string>()),
          options.at("ridges").get<std::vector<double>>(),
          options.at("iterations").get<std::size_t>()};
}

double root_mean_square(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

/// The errors of all cases of a set with these constants.
std::vector<double> errors_with(const springs::RankOneTerms& terms, const std::vector<double>& constant,
                                const springs::TrainingSet& set) {
  std::vector<double> errors;
  for (const springs::CaseResult& result : springs::solve_cases(terms, constant, set))
    errors.push_back(result.relative_error);
  return errors;
}

/// Springs by the wish's method with its volume model, all constants at what the material says.
SpringStart build_spring_start(const TetMesh& mesh, const TrainingWish& wish, bool face_opposite,
                               bool calibrated, std::vector<std::string>& notes) {
  const auto volume = wish.volume == TrainedVolume::kNone ? dynamics::VolumeModel::kNone
                                                          : dynamics::VolumeModel::kNodeAverage;
  const Material material = dynamics::spring_material(wish.material, volume);
  springs::IdentifyOptions options;
  options.face_opposite = face_opposite;
  springs::IdentifyReport report;
  SpringStart start;
  start.network = springs::identify_springs(mesh, material, wish.start, options, report);
  notes.insert(notes.end(), report.warnings.begin(), report.warnings.end());
  if (calibrated) calibrate_springs(mesh, material.mu_pa(), start.network);
  springs::add_spring_terms(mesh, start.network, kLeastShare, start.terms);
  // At Poisson's ratio 1/4 the start would be zero, which has no logarithm.
  const double modulus =
      std::max(wish.material.lambda_pa() - wish.material.mu_pa(), kLeastModulus * wish.material.mu_pa());
  if (wish.volume == TrainedVolume::kTet) springs::add_tet_dilatation_terms(mesh, modulus, start.terms);
  if (wish.volume == TrainedVolume::kNodeAverage)
    springs::add_vertex_dilatation_terms(mesh, modulus, start.terms);
  return start;
}

TrainingFits fit_ridges(const TrainingWish& wish, const SpringStart& start,
                        const std::vector<TrainingSplit>& splits) {
  TrainingFits fits;
  const springs::TrainingSet& validate = splits[kValidateSplit].set;
  fits.start_validate_rms = root_mean_square(errors_with(start.terms, start.terms.constant, validate));
  tell({{"fits", wish.ridges.size()}});
  const Stopwatch watch;
  for (const double ridge : wish.ridges) {
    tell({{"now", "fit with ridge " + short_number(ridge)}});
    springs::TrainingOptions options;
    options.ridge = ridge;
    options.lbfgs.max_iterations = wish.iterations;
    const springs::TrainingReport report =
        springs::fit_constants(start.terms, splits[kTrainSplit].set, options);
    RidgeResult result{ridge, report.error_after, 0.0, report.lbfgs};
    result.validate_rms = root_mean_square(errors_with(start.terms, report.constant, validate));
    if (fits.ridges.empty() || result.validate_rms < fits.ridges[fits.chosen].validate_rms) {
      fits.chosen = fits.ridges.size();
      fits.constant = report.constant;
    }
    tell({{"said", "ridge " + short_number(ridge) + ": train " + short_number(100.0 * result.train_rms) +
                       "%, validate " + short_number(100.0 * result.validate_rms) + "%"}});
    fits.ridges.push_back(result);
    const auto done = static_cast<double>(fits.ridges.size());
    tell({{"left_s", watch.seconds() / done * (static_cast<double>(wish.ridges.size()) - done)}});
  }
  fits.start_is_kept = fits.start_validate_rms <= fits.ridges[fits.chosen].validate_rms;
  if (fits.start_is_kept) fits.constant = start.terms.constant;
  return fits;
}

json describe_errors(const std::vector<double>& errors) {
  return {{"rms", root_mean_square(errors)},
          {"worst", *std::max_element(errors.begin(), errors.end())},
          {"errors", errors}};
}

json describe_split(const SpringStart& start, const SpringStart& opposite, const TrainingFits& fits,
                    const TrainingSplit& split) {
  json out;
  for (const springs::TrainingCase& one : split.set.cases) out["cases"].push_back(one.name);
  json& models = out["models"];
  models["start"] = describe_errors(errors_with(start.terms, start.terms.constant, split.set));
  models["calibrated_opposite"] =
      describe_errors(errors_with(opposite.terms, opposite.terms.constant, split.set));
  models["fem_p1"] = describe_errors(split.linear_elements);
  models["trained"] = describe_errors(errors_with(start.terms, fits.constant, split.set));
  return out;
}

json describe_fits(const TetMesh& mesh, const SpringStart& start, const TrainingFits& fits) {
  const std::size_t springs = start.network.springs.size();
  json report{{"vertices", mesh.points.size()},
              {"springs", springs},
              {"moduli", fits.constant.size() - springs},
              {"kept", fits.start_is_kept ? "start" : "trained"},
              {"start_validate_rms", fits.start_validate_rms},
              {"ridge", fits.start_is_kept ? json(nullptr) : json(fits.ridges[fits.chosen].ridge)}};
  for (const RidgeResult& result : fits.ridges)
    report["ridges"].push_back({{"ridge", result.ridge},
                                {"train_rms", result.train_rms},
                                {"validate_rms", result.validate_rms},
                                {"iterations", result.lbfgs.iterations},
                                {"evaluations", result.lbfgs.evaluations}});
  return report;
}

void write_constants(const Request& request, TrainedVolume volume, SpringNetwork network,
                     const std::vector<double>& constant) {
  require(constant.size() >= network.springs.size(), "training: one constant a spring");
  const auto first = constant.begin() + static_cast<std::ptrdiff_t>(network.springs.size());
  std::copy(constant.begin(), first, network.stiffness_n_per_m.begin());
  springs::write_springs_csv(request.output, network);
  if (volume == TrainedVolume::kNone) return;
  springs::write_moduli_csv(request.options.at("moduli_out").get<std::string>(),
                            {volume == TrainedVolume::kNodeAverage, {first, constant.end()}});
}

}  // namespace

Response run_training(const Request& request) {
  const TrainingWish wish = read_wish(request);
  require(!wish.ridges.empty(), "training: at least one ridge");
  const TetMesh mesh = read_medit(request.input, ReadOrientation::kKeep).mesh;
  const Stopwatch kernel;
  Response response;
  const SpringStart start =
      build_spring_start(mesh, wish, wish.face_opposite, wish.calibrate, response.notes);
  for (const std::string& note : response.notes) tell({{"note", note}});
  std::vector<TrainingSplit> splits;
  for (const json& split : request.options.at("splits")) splits.push_back(read_training_split(split, mesh));
  require(splits.size() > kValidateSplit, "training: a set to train on and one to validate");
  const TrainingFits fits = fit_ridges(wish, start, splits);
  response.report = describe_fits(mesh, start, fits);
  std::vector<std::string> ignored;
  const SpringStart opposite = build_spring_start(mesh, wish, true, true, ignored);
  for (const TrainingSplit& split : splits)
    response.report["sets"][split.name] = describe_split(start, opposite, fits, split);
  response.kernel_s = kernel.seconds();
  write_constants(request, wish.volume, start.network, fits.constant);
  return response;
}

}  // namespace palpate::reference

#include "experiments/fit/candidates/fit_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>

#include "core/base/atomic_file.h"
#include "core/base/number_text.h"
#include "core/base/random.h"
#include "core/base/types.h"
#include "experiments/files/output_file.h"
#include "experiments/plan_reader/plan.h"
#include "experiments/scene_writer/placed_text.h"
#include "experiments/text/yaml_value.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

constexpr double kMostTurn = std::numbers::pi / 6.0;        // of a load
constexpr double kMostPlaceTurn = std::numbers::pi / 12.0;  // of a place on the surface
constexpr double kMostGrowth = 0.3;
constexpr double kMostShift = 0.5;  // radii
// At which a reference stops: it moves a kidney by less than 1e-7 of its displacement (docs/fit.md), four
// orders below what two levels of the mesh differ by, and saves two fifths of the iterations.
constexpr double kReferenceResidual = 1e-6;

Vec3 vector_of(const json& list) {
  return {list.at(0).get<double>(), list.at(1).get<double>(), list.at(2).get<double>()};
}

json list_of(const Vec3& v) {
  return {v.x, v.y, v.z};
}

/// Points of the range of loads. On its border, spread evenly however many there are: a Kronecker sequence by
/// the inverse powers of the root of x^4 = x + 1 (M. Roberts' R3), another offset for each further number.
/// Anywhere in it, drawn at random, the number being the seed.
class RangePoint {
 public:
  RangePoint(std::uint64_t number, LoadRange range)
      : number_(static_cast<double>(number)), range_(range), random_(number) {}

  /// The point's next number, in [0, 1).
  double next_share() {
    if (range_ == LoadRange::kWhole) return random_.uniform();
    constexpr std::array kSteps = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
    constexpr double kGolden = 0.6180339887498949;
    const double share = number_ * kSteps[count_ % kSteps.size()] + static_cast<double>(count_) * kGolden;
    ++count_;
    return share - std::floor(share);
  }

  /// How far towards the border it is, in [0, 1].
  double next_reach() { return range_ == LoadRange::kBorder ? 1.0 : random_.uniform(); }

  /// What the scene's own size is multiplied by.
  double next_growth() {
    const double share = next_share();
    if (range_ == LoadRange::kBorder) return share < 0.5 ? 1.0 - kMostGrowth : 1.0 + kMostGrowth;
    return 1.0 + kMostGrowth * (2.0 * share - 1.0);
  }

  double next_angle() { return 2.0 * std::numbers::pi * next_share(); }

  Vec3 next_unit_vector() {
    const double z = 2.0 * next_share() - 1.0;
    const double angle = next_angle();
    const double radius = std::sqrt(1.0 - z * z);
    return {radius * std::cos(angle), radius * std::sin(angle), z};
  }

 private:
  double number_;
  LoadRange range_;
  SplitMix64 random_;
  std::size_t count_ = 0;
};

/// `v` turned by `angle` towards a direction across it, which is told by `azimuth`.
Vec3 turned(const Vec3& v, double angle, double azimuth) {
  const double size = length(v);
  if (!(size > 0.0)) return v;
  const Vec3 along = (1.0 / size) * v;
  constexpr double kMostlyX = 0.9;
  const Vec3 any = std::abs(along.x) > kMostlyX ? Vec3{0.0, 1.0, 0.0} : Vec3{1.0, 0.0, 0.0};
  const Vec3 rejected = any - dot(any, along) * along;
  const Vec3 first = (1.0 / length(rejected)) * rejected;
  const Vec3 across = std::cos(azimuth) * first + std::sin(azimuth) * cross(along, first);
  return size * (std::cos(angle) * along + std::sin(angle) * across);
}

void perturb_vector(json& list, RangePoint& point) {
  const double angle = kMostTurn * point.next_reach();
  const Vec3 v = turned(vector_of(list), angle, point.next_angle());
  list = list_of(point.next_growth() * v);
}

/// Moves a sphere; half-spaces and boxes are parts of the body that a load means, and stay.
void perturb_place(json& load, RangePoint& point) {
  if (!load.contains("sphere")) return;
  json& sphere = load["sphere"];
  if (sphere.contains("surface_point")) {
    json& direction = sphere["surface_point"]["direction"];
    const double angle = kMostPlaceTurn * point.next_reach();
    direction = list_of(turned(vector_of(direction), angle, point.next_angle()));
  } else if (sphere.contains("center_m") && sphere.contains("radius_m")) {
    const double shift = kMostShift * sphere["radius_m"].get<double>() * point.next_reach();
    sphere["center_m"] = list_of(vector_of(sphere["center_m"]) + shift * point.next_unit_vector());
  }
}

/// A load as it is at its greatest share.
json static_load(json load) {
  double share = 1.0;
  if (load.contains("profile")) {
    const std::vector<double> shares = load["profile"].value("shares", std::vector<double>{1.0});
    share = *std::max_element(shares.begin(), shares.end(),
                              [](double a, double b) { return std::abs(a) < std::abs(b); });
  }
  for (const char* key : {"profile", "from_s", "until_s"}) load.erase(key);
  const auto scale = [&](json& list) { list = list_of(share * vector_of(list)); };
  if (load.contains("gravity_m_s2")) scale(load["gravity_m_s2"]);
  if (load.contains("displace")) scale(load["displace"]["by_m"]);
  if (load.contains("force")) scale(load["force"]["total_n"]);
  return load;
}

/// Leaves of a requirement where its error is asked for, with the probes that it names: a scene at rest has
/// none of an analysis.
void keep_error_places(const Scene& scene, json& out) {
  json error = out["require"]["error"];
  out.erase("require");
  out.erase("probes_m");
  if (!scene.require || scene.require->places.empty()) return;
  out["require"]["error"] = std::move(error);
  for (const ErrorPlace& place : scene.require->places) {
    if (place.probe) out["probes_m"][place.probe->name] = list_of(place.probe->place_m);
  }
}

json contestant_json(const FitCandidate& candidate, const FitPlan& plan, bool is_large) {
  const FitModel& model = candidate.model;
  json set = model.set;
  const bool reports_cost = !model.method.starts_with("reduced.");
  const bool asks_answers = plan.work == FitWork::kFurther || plan.measures_answers;
  if (asks_answers && reports_cost && !is_large) set["cost"] = true;
  if (plan.work == FitWork::kSecond) set["step_cost"] = true;
  json entry{{"method", model.method}, {"label", plan_label(candidate)}, {"required", false}};
  if (!set.empty()) entry["set"] = set;
  entry["at"]["simplify"] = candidate.simplifier;
  if (candidate.ratio) entry["at"]["tets_removed_ratio"] = *candidate.ratio;
  return entry;
}

/// The simplifiers that the candidates name, and the shares that they ask for.
void add_simplifiers(const FitPlan& plan, const FitCandidates& known, json& out) {
  std::set<std::string> used;
  std::set<double> ratios;
  for (const FitCandidate& candidate : plan.candidates) {
    used.insert(candidate.simplifier);
    if (candidate.ratio) ratios.insert(*candidate.ratio);
  }
  out["simplify"] = json::array();
  if (used.count(kNoSimplifier) > 0) out["simplify"].push_back(kNoSimplifier);
  for (const FitSimplifier& simplifier : known.simplifiers) {
    if (used.count(simplifier.label) > 0)
      out["simplify"].push_back(
          {{"method", simplifier.method}, {"label", simplifier.label}, {"set", simplifier.set}});
  }
  if (!ratios.empty()) out["sweep"]["tets_removed_ratio"] = ratios;
}

}  // namespace

std::string FitCandidate::name() const {
  if (!ratio) return model.label + ", the mesh as it is";
  return model.label + ", " + simplifier + " -" + short_number(100.0 * *ratio) + "%";
}

std::string plan_label(const FitCandidate& candidate) {
  std::string label = candidate.model.label + "-" + candidate.simplifier;
  if (candidate.ratio) label += "-" + short_number(*candidate.ratio);
  return label;
}

std::vector<FitCandidate> list_candidates(const FitCandidates& candidates, FitWork work,
                                          const SceneRequirement& require,
                                          std::vector<std::string>& dropped) {
  std::vector<FitCandidate> found;
  for (const FitModel& model : candidates.models) {
    if (const std::string missing = model.cannot(work, require.needs); !missing.empty()) {
      dropped.push_back(model.label + " (" + model.method + ") cannot do: " + missing);
      continue;
    }
    found.push_back({model, kNoSimplifier, std::nullopt});
    for (const FitSimplifier& simplifier : candidates.simplifiers) {
      for (const double ratio : simplifier.ratios) found.push_back({model, simplifier.label, ratio});
    }
  }
  return found;
}

json static_scene(const Scene& scene) {
  json out = read_yaml(scene.file).json();
  for (const char* key : {"model", "envelope"}) out.erase(key);
  keep_error_places(scene, out);
  out["analysis"] = "static";
  const auto absolute = [](const fs::path& file) { return fs::absolute(file).lexically_normal().string(); };
  if (!scene.mesh.shape) out["mesh"]["file"] = absolute(scene.mesh.file);
  if (!scene.mesh.regions_from.empty()) out["mesh"]["regions_from"] = absolute(scene.mesh.regions_from);
  for (json& load : out["load"]) load = static_load(load);
  return out;
}

fs::path whole_mesh_of(const FitCandidate& candidate, const fs::path& run) {
  return candidate.simplifier == kNoSimplifier ? fs::path() : run / "problems" / "scene_0" / "in.mesh";
}

json build_fitted_scene(const Scene& placed, const FitModel& model, const fs::path& whole) {
  json scene = placed_scene(placed, "organ.mesh");
  if (!whole.empty() && placed.whole == nullptr)
    scene["mesh"]["regions_from"] = fs::absolute(whole).lexically_normal().string();
  const std::size_t dot = model.method.find('.');
  const std::string kind = model.method.substr(0, dot);
  scene["model"] = model.set;
  scene["model"][kind == "fem" ? "finite_elements" : kind] = model.method.substr(dot + 1);
  return scene;
}

json perturbed_scene(const json& scene, std::uint64_t number, LoadRange range, bool moves_places) {
  json out = scene;
  RangePoint point(number, range);
  for (json& load : out["load"]) {
    if (load.contains("gravity_m_s2")) perturb_vector(load["gravity_m_s2"], point);
    if (load.contains("displace")) {
      if (moves_places) perturb_place(load["displace"], point);
      perturb_vector(load["displace"]["by_m"], point);
    }
    if (load.contains("force")) {
      if (moves_places) perturb_place(load["force"], point);
      perturb_vector(load["force"]["total_n"], point);
    }
  }
  return out;
}

fs::path write_fit_plan(const FitPlan& plan, const FitCandidates& candidates) {
  create_folder(plan.folder);
  json out{{"schema", "palpate/plan/1"},
           {"question", "Which of these meets the scene's tolerance at the least cost?"},
           {"contest", "deform"}};
  bool is_large = false;
  for (std::size_t k = 0; k < plan.scenes.size(); ++k) {
    const std::string name = "scene_" + std::to_string(k);
    write_file_atomically(plan.folder / (name + ".yaml"), plan.scenes[k].dump(1) + "\n");
    out["scenes"].push_back({{"name", name}, {"file", name + ".yaml"}});
    is_large = is_large || plan.scenes[k].value("strain", "small") == "large";
  }
  out["reference"] = {{"method", "fem.p2"},
                      {"levels", plan.levels},
                      {"enough", plan.enough},
                      {"set", {{"rtol", kReferenceResidual}}}};
  add_simplifiers(plan, candidates, out);
  for (const FitCandidate& candidate : plan.candidates)
    out["contestants"].push_back(contestant_json(candidate, plan, is_large));
  out["run"] = {{"repeats", plan.repeats},
                {"warmup", plan.repeats > 1 ? 1 : 0},
                {"threads", 1},
                {"timeout_s", 120},
                {"memory_mib", 8192}};
  out["measure"] = {"displacement_deformation",
                    "displacement_l2",
                    "displacement_energy",
                    "displacement_max",
                    "displacement_deformation_at",
                    "displacement_l2_at",
                    "displacement_max_at",
                    "pad_force",
                    "kernel_s",
                    "answer_s",
                    "simplify_s",
                    "simulated_second_s",
                    "explicit_step_s",
                    "peak_rss_bytes"};
  fs::path file = plan.folder / "plan.yaml";
  write_file_atomically(file, out.dump(1) + "\n");
  return file;
}

}  // namespace palpate::experiments

#include "experiments/contests/stability/stability_input.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/mesh/geometry.h"
#include "experiments/contests/stability/driven_mesh.h"
#include "experiments/registry/option_spec.h"
#include "experiments/registry/stability_settings.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using reference::StabilityProblem;

constexpr double kYoungPa = 1e4;
constexpr double kDensity = 1050.0;
constexpr double kHeldShare = 0.1;

/// The settings as a case has them, or their defaults.
class Settings {
 public:
  explicit Settings(const json& options) : options_(options) {}

  double number(const char* name) const { return value(name).get<double>(); }
  std::uint64_t whole(const char* name) const { return value(name).get<std::uint64_t>(); }
  bool is(const char* name, const char* choice) const { return value(name) == choice; }

  std::size_t choice(const char* name) const {
    const std::vector<std::string>& choices = spec(name).choices;
    const auto found = std::find(choices.begin(), choices.end(), value(name));
    require(found != choices.end(), "a choice that the plan's reader knows");
    return static_cast<std::size_t>(found - choices.begin());
  }

 private:
  static const OptionSpec& spec(const std::string& name) {
    const std::vector<OptionSpec>& all = stability_settings();
    const auto found =
        std::find_if(all.begin(), all.end(), [&](const OptionSpec& s) { return s.name == name; });
    require(found != all.end(), "a setting of the contest");
    return *found;
  }

  json value(const char* name) const { return options_.value(name, spec(name).default_value); }

  const json& options_;
};

ExtremeMesh read_mesh_settings(const Settings& settings) {
  ExtremeMesh out;
  out.size_m = settings.number("size_m");
  out.size_ratio = settings.number("size_ratio");
  out.sliver_deg = settings.number("sliver_deg");
  out.coordinate_scale = settings.number("coordinate_scale");
  out.coordinate_shift_m = settings.number("coordinate_shift_m");
  out.seed = settings.whole("seed");
  return out;
}

void check_volumes(const TetMesh& mesh) {
  for (const auto& [a, b, c, d] : mesh.tets) {
    if (!(signed_volume(mesh.points[a], mesh.points[b], mesh.points[c], mesh.points[d]) > 0.0))
      throw InputError("mesh", 0, "tets that are not flat", "one without volume");
  }
}

void add_masses(const Settings& settings, std::size_t vertices, StabilityProblem& problem) {
  const double factor = settings.number("mass_factor");
  const double ratio = settings.number("mass_ratio");
  if (!(factor > 0.0)) throw InputError("mass_factor", 0, "a number above zero", std::to_string(factor));
  SplitMix64 random(problem.seed);
  for (std::size_t v = 0; v < vertices; ++v)
    problem.mass_factors.push_back(factor * std::pow(ratio, random.uniform()));
}

void add_held(const TetMesh& mesh, StabilityProblem& problem) {
  const BoundingBox box = bounding_box(mesh.points);
  const double limit = box.low.x + kHeldShare * (box.high.x - box.low.x);
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    if (mesh.points[v].x <= limit) problem.held.push_back(static_cast<Index>(v));
  }
}

void add_start(const Settings& settings, const TetMesh& mesh, StabilityProblem& problem) {
  const BoundingBox box = bounding_box(mesh.points);
  const Vec3 side = box.high - box.low;
  const double size = std::max({side.x, side.y, side.z});
  const double low = box.low.x;
  const double mirror = 0.25 * box.low.x + 0.75 * box.high.x;
  const double strain = settings.number("strain");
  SplitMix64 random(problem.seed);
  const auto next = [&] { return strain * size * (2.0 * random.uniform() - 1.0); };
  for (const Vec3& p : mesh.points) {
    Vec3 u;
    if (settings.is("start", "random")) u = {next(), next(), next()};
    if (settings.is("start", "stretch")) u.x = strain * (p.x - low);
    if (settings.is("start", "shear")) u.y = strain * (p.x - low);
    if (settings.is("start", "invert") && p.x > mirror) u.x = -2.0 * strain * (p.x - mirror);
    if (!is_finite(u))
      throw InputError("strain", 0, "one that gives finite displacements", std::to_string(strain));
    problem.start_m.push_back(u);
  }
  for (const Index v : problem.held) problem.start_m[v] = {};
}

}  // namespace

StabilityInput build_stability_input(const TetMesh& mesh, const json& options) {
  const Settings settings(options);
  DrivenMesh driven = drive_mesh(mesh, read_mesh_settings(settings));
  StabilityInput out{std::move(driven.mesh), {}, driven.flattened, driven.min_dihedral_deg};
  check_volumes(out.mesh);
  StabilityProblem& problem = out.problem;
  problem.material = {kYoungPa, settings.number("poisson_ratio"), kDensity};
  problem.stiffness_factor = settings.number("stiffness_factor");
  problem.damping = static_cast<reference::DampingLaw>(settings.choice("damping"));
  problem.damping_ratio = settings.number("damping_ratio");
  problem.seed = settings.whole("seed");
  add_masses(settings, out.mesh.points.size(), problem);
  if (settings.is("held", "end")) add_held(out.mesh, problem);
  add_start(settings, out.mesh, problem);
  return out;
}

json own_options(const json& options) {
  json own = options;
  for (const OptionSpec& setting : stability_settings()) own.erase(setting.name);
  return own;
}

}  // namespace palpate::experiments

#include "core/dynamics/statics/static_equilibrium.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/enum_names.h"
#include "core/base/error.h"
#include "core/base/random.h"
#include "core/dynamics/linear_algebra/vertex_field.h"
#include "core/dynamics/statics/tangent_system.h"
#include "core/mesh/geometry.h"

namespace palpate::dynamics {
namespace {

constexpr EnumNames<StaticOutcome, 5> kOutcomeNames{
    "an equilibrium's outcome", {"converged", "buckled", "inverted", "diverged", "not_converged"}};

using Field = std::vector<Vec3>;

Field sum_of(std::span<const Vec3> a, double s, std::span<const Vec3> b) {
  Field out(a.begin(), a.end());
  add_scaled(out, s, b);
  return out;
}

/// The components that are free, or those that are held.
Field pick(const Loads& loads, std::span<const Vec3> a, bool held) {
  Field out(a.begin(), a.end());
  for (std::size_t v = 0; v < out.size(); ++v) {
    if (((loads.held[v] & 1U) != 0) != held) out[v].x = 0.0;
    if (((loads.held[v] & 2U) != 0) != held) out[v].y = 0.0;
    if (((loads.held[v] & 4U) != 0) != held) out[v].z = 0.0;
  }
  return out;
}

struct VolumeCount {
  std::size_t inverted = 0;
  double least_ratio = 1.0;
};

VolumeCount count_inverted(const TetMesh& mesh, std::span<const Vec3> u) {
  VolumeCount count;
  for (const Tet& t : mesh.tets) {
    const auto at = [&](std::size_t k) { return mesh.points[t[k]] + u[t[k]]; };
    const double now = signed_volume(at(0), at(1), at(2), at(3));
    const double rest =
        signed_volume(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], mesh.points[t[3]]);
    if (!(now > 0.0)) ++count.inverted;
    count.least_ratio = std::min(count.least_ratio, now / rest);
  }
  return count;
}

/// The search for one equilibrium.
class Search {
 public:
  Search(const TetMesh& mesh, const ElasticModel& model, const Loads& loads, const StaticOptions& options)
      : mesh_(mesh), model_(model), loads_(loads), options_(options), system_(model, loads, options.linear) {
    const BoundingBox box = bounding_box(mesh.points);
    bound_ = 1e3 * length(box.high - box.low);
  }

  StaticSolution linearise();
  StaticSolution follow_loads();

 private:
  enum class StepEnd { kDone, kOutOfIterations, kDiverged };

  /// Forces out of balance at a displacement, and their size over that of all that acts.
  struct Balance {
    Field free;
    double relative = 0.0;
  };
  Balance find_balance(std::span<const Vec3> u, double scale) const;
  double potential(std::span<const Vec3> u, double scale) const {
    return elastic_energy(model_, u) + load_energy(loads_, u, scale);
  }
  bool is_in_bounds(std::span<const Vec3> u) const {
    return std::all_of(u.begin(), u.end(), [&](const Vec3& a) { return is_finite(a) && length(a) < bound_; });
  }

  std::optional<Field> find_step(std::span<const Vec3> u, std::span<const Vec3> free, double relative,
                                 std::span<const Vec3> held_step);
  std::optional<Field> search_line(std::span<const Vec3> u, double scale, const Balance& balance,
                                   std::span<const Vec3> step) const;
  StepEnd balance_loads(Field& u, double from, double to);
  bool is_stable(std::span<const Vec3> u);

  const TetMesh& mesh_;
  const ElasticModel& model_;
  const Loads& loads_;
  const StaticOptions& options_;
  TangentSystem system_;
  double bound_ = 0.0;
  bool last_was_indefinite_ = false;
  StaticReport report_;
};

Search::Balance Search::find_balance(std::span<const Vec3> u, double scale) const {
  Field elastic(u.size());
  add_elastic_forces(model_, u, elastic);
  Field outer(u.size());
  add_load_forces(loads_, u, scale, outer);
  const Field all = sum_of(elastic, 1.0, outer);
  Balance balance{pick(loads_, all, false), 0.0};
  const double acting = norm_of(outer) + norm_of(pick(loads_, all, true));
  const double off = norm_of(balance.free);
  balance.relative = off == 0.0 ? 0.0 : off / std::max(acting, 1e-300);
  return balance;
}

/// Solves tangent x step = free forces, the held components moving by `held_step`. Nothing if even a
/// semidefinite tangent with a raised diagonal cannot be solved with.
std::optional<Field> Search::find_step(std::span<const Vec3> u, std::span<const Vec3> free, double relative,
                                       std::span<const Vec3> held_step) {
  // Conjugate gradients need no more digits than the next iterate will have.
  const double tolerance = options_.linearised ? std::min(0.1 * options_.tolerance, options_.linear.tolerance)
                                               : std::clamp(0.1 * relative, 1e-9, 1e-2);
  constexpr double kFirstShift = 1e-8;
  constexpr double kLastShift = 10.0;
  Field step(u.size());
  Field moved(u.size());
  last_was_indefinite_ = false;
  for (double shift = 0.0; shift <= kLastShift;) {
    const bool exact = !last_was_indefinite_;
    LinearStatus status = system_.prepare(u, exact ? TangentKind::kExact : TangentKind::kProjected, shift);
    if (status == LinearStatus::kSolved) {
      system_.apply(held_step, moved);
      const LinearResult result = system_.solve(sum_of(free, -1.0, moved), tolerance, step);
      report_.linear_iterations += result.iterations;
      status = result.status;
    }
    if (status == LinearStatus::kSolved) return sum_of(step, 1.0, held_step);
    if (options_.linearised) {
      last_was_indefinite_ = status == LinearStatus::kIndefinite;
      return std::nullopt;
    }
    if (exact) {
      if (status == LinearStatus::kIndefinite) ++report_.indefinite_tangents;
    } else {
      shift = shift == 0.0 ? kFirstShift : 30.0 * shift;
    }
    last_was_indefinite_ = true;
  }
  return std::nullopt;
}

/// The first of u + step, u + step / 2, ... that is good enough.
std::optional<Field> Search::search_line(std::span<const Vec3> u, double scale, const Balance& balance,
                                         std::span<const Vec3> step) const {
  constexpr int kMostHalvings = 40;
  constexpr double kArmijo = 1e-4;
  // Below this share of the energies a fall drowns in their rounding; Newton's step is safe there.
  constexpr double kRounding = 1e-10;
  const double elastic = elastic_energy(model_, u);
  const double outer = load_energy(loads_, u, scale);
  const double slope = dot_of(balance.free, step);
  double share = 1.0;
  for (int k = 0; k < kMostHalvings; ++k, share *= 0.5) {
    Field trial = sum_of(u, share, step);
    if (!is_in_bounds(trial)) continue;
    if (!system_.is_symmetric()) {
      if (find_balance(trial, scale).relative <= (1.0 - kArmijo * share) * balance.relative) return trial;
      continue;
    }
    const double now = potential(trial, scale);
    const double least_fall = kArmijo * share * slope;
    const bool drowns = slope <= kRounding * (std::abs(elastic) + std::abs(outer));
    if (std::isfinite(now) && (now <= elastic + outer - least_fall || drowns)) return trial;
  }
  return std::nullopt;
}

/// Newton's method from the equilibrium `u` at the load `from` to that at `to`.
Search::StepEnd Search::balance_loads(Field& u, double from, double to) {
  Field held_step(u.size());
  for (std::size_t v = 0; v < u.size(); ++v) held_step[v] = (to - from) * loads_.held_by_m[v];
  bool moves_held = norm_of(held_step) > 0.0;
  report_.residuals.clear();
  const Field still(u.size());
  for (std::size_t k = 0; k < options_.max_iterations; ++k) {
    const Balance balance = find_balance(u, to);
    if (!std::isfinite(balance.relative)) return StepEnd::kDiverged;
    report_.residuals.push_back(balance.relative);
    report_.residual_relative = balance.relative;
    if (balance.relative <= options_.tolerance && !moves_held) return StepEnd::kDone;
    const std::optional<Field> step =
        find_step(u, balance.free, balance.relative, moves_held ? held_step : still);
    if (!step) return StepEnd::kOutOfIterations;
    ++report_.iterations;
    if (moves_held) {
      // The held faces have to arrive: this step is taken whole, or the load step is halved.
      Field trial = sum_of(u, 1.0, *step);
      if (!is_in_bounds(trial) || !std::isfinite(potential(trial, to))) return StepEnd::kDiverged;
      u = std::move(trial);
      moves_held = false;
      continue;
    }
    std::optional<Field> next = search_line(u, to, balance, *step);
    if (!next) return StepEnd::kOutOfIterations;
    u = std::move(*next);
  }
  return StepEnd::kOutOfIterations;
}

/// Whether the tangent at an equilibrium is positive definite. A factorisation decides; conjugate gradients
/// look along the directions that a random right-hand side spans.
bool Search::is_stable(std::span<const Vec3> u) {
  if (system_.prepare(u, TangentKind::kExact, 0.0) != LinearStatus::kSolved) return false;
  if (system_.is_direct()) return true;
  constexpr std::uint64_t kSeed = 20081121;
  SplitMix64 random(kSeed);
  Field b(u.size());
  for (Vec3& entry : b) entry = {random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
  Field x(u.size());
  const LinearResult result = system_.solve(b, 1e-2, x);
  report_.linear_iterations += result.iterations;
  return result.status != LinearStatus::kIndefinite;
}

StaticSolution Search::follow_loads() {
  StaticSolution solution{Field(mesh_.points.size()), {}};
  Field& u = solution.displacement_m;
  const double full_step = 1.0 / std::max(options_.load_steps, 1);
  double at = 0.0;
  double step = full_step;
  int halvings = 0;
  report_.outcome = StaticOutcome::kConverged;
  while (at < 1.0) {
    const double to = at + step >= 1.0 - 1e-12 ? 1.0 : at + step;
    Field trial = u;
    const StepEnd end = balance_loads(trial, at, to);
    ++report_.load_steps;
    const bool may_halve = halvings < options_.max_halvings;
    const bool is_done = end == StepEnd::kDone;
    if (is_done && (!may_halve || count_inverted(mesh_, trial).inverted == 0)) {
      u = std::move(trial);
      at = to;
      continue;
    }
    if (!may_halve) {
      report_.outcome = end == StepEnd::kDiverged ? StaticOutcome::kDiverged : StaticOutcome::kNotConverged;
      break;
    }
    ++halvings;
    step *= 0.5;
  }
  const VolumeCount volumes = count_inverted(mesh_, u);
  report_.inverted_tets = volumes.inverted;
  report_.least_volume_ratio = volumes.least_ratio;
  if (report_.outcome == StaticOutcome::kConverged && volumes.inverted > 0)
    report_.outcome = StaticOutcome::kInverted;
  else if (report_.outcome == StaticOutcome::kConverged && !is_stable(u))
    report_.outcome = StaticOutcome::kBuckled;
  if (report_.outcome == StaticOutcome::kDiverged) std::fill(u.begin(), u.end(), Vec3{});
  report_.elastic_energy_j = elastic_energy(model_, u);
  report_.potential_j = report_.elastic_energy_j + load_energy(loads_, u, at);
  solution.report = report_;
  return solution;
}

StaticSolution Search::linearise() {
  const std::size_t n = mesh_.points.size();
  StaticSolution solution{Field(n), {}};
  const Field rest(n);
  Field outer(n);
  add_load_forces(loads_, rest, 1.0, outer);
  const std::optional<Field> step = find_step(rest, pick(loads_, outer, false), 1.0, loads_.held_by_m);
  report_.iterations = 1;
  report_.load_steps = 1;
  if (!step) {
    report_.outcome = last_was_indefinite_ ? StaticOutcome::kBuckled : StaticOutcome::kNotConverged;
    solution.report = report_;
    return solution;
  }
  solution.displacement_m = *step;
  Field inner(n);
  system_.apply(*step, inner);
  const Field off = sum_of(outer, -1.0, inner);
  const double acting = norm_of(outer) + norm_of(pick(loads_, off, true));
  report_.residual_relative = norm_of(pick(loads_, off, false)) / std::max(acting, 1e-300);
  report_.residuals = {report_.residual_relative};
  Loads springs_of_supports = loads_;
  springs_of_supports.force_n.assign(n, Vec3{});
  report_.elastic_energy_j = 0.5 * dot_of(*step, inner) - load_energy(springs_of_supports, *step, 0.0);
  report_.potential_j = report_.elastic_energy_j + load_energy(loads_, *step, 1.0);
  const bool is_good = is_in_bounds(*step) && report_.residual_relative <= std::max(options_.tolerance, 1e-9);
  report_.outcome = is_good ? StaticOutcome::kConverged
                            : (is_in_bounds(*step) ? StaticOutcome::kNotConverged : StaticOutcome::kDiverged);
  if (report_.outcome == StaticOutcome::kDiverged) solution.displacement_m.assign(n, Vec3{});
  const VolumeCount volumes = count_inverted(mesh_, solution.displacement_m);
  report_.inverted_tets = volumes.inverted;
  report_.least_volume_ratio = volumes.least_ratio;
  solution.report = report_;
  return solution;
}

}  // namespace

const char* static_outcome_name(StaticOutcome outcome) {
  return kOutcomeNames.of(outcome);
}

StaticSolution solve_static(const TetMesh& mesh, const ElasticModel& model, const Loads& loads,
                            const StaticOptions& options) {
  require(mesh.points.size() == model.rest.size() && loads.force_n.size() == model.rest.size(),
          "mesh, model and loads of the same vertices");
  require_no_rigid_motion(mesh, loads);
  Search search(mesh, model, loads, options);
  return options.linearised ? search.linearise() : search.follow_loads();
}

}  // namespace palpate::dynamics

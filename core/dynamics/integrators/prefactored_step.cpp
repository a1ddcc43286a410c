#include "core/dynamics/integrators/prefactored_step.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "core/base/error.h"
#include "core/dynamics/linear_algebra/curvature_pairs.h"
#include "core/dynamics/linear_algebra/laplace_factor.h"
#include "core/dynamics/linear_algebra/vertex_field.h"

namespace palpate::dynamics {
namespace {

/// A correction that ends on the other side, with more than this share of the slope that it began with, goes
/// too far. (-1 is where a quadratic energy would be what it was.)
constexpr double kTooFar = 0.9;
constexpr int kMostTries = 20;
constexpr double kGreatestCut = 0.1;  ///< of a correction, at a time

bool is_held(std::uint8_t bits, std::size_t axis) {
  return ((static_cast<unsigned>(bits) >> axis) & 1U) != 0;
}

/// The matrix of all vertices, held or not.
std::vector<ScalarEntry> build_entries(const MotionModel& model, double h) {
  std::vector<ScalarEntry> entries;
  const ElasticModel& elastic = model.elastic;
  for (std::size_t v = 0; v < model.mass_kg.size(); ++v) {
    const double drag =
        model.environment_damping_n_s_per_m.empty() ? 0.0 : model.environment_damping_n_s_per_m[v];
    entries.push_back({static_cast<Index>(v), static_cast<Index>(v), model.mass_kg[v] / (h * h) + drag / h});
  }
  for (std::size_t s = 0; s < elastic.springs.springs.size(); ++s) {
    const auto [a, b] = elastic.springs.springs[s];
    const double damping = model.spring_damping_n_s_per_m.empty() ? 0.0 : model.spring_damping_n_s_per_m[s];
    const double weight = elastic.springs.stiffness_n_per_m[s] + damping / h;
    entries.push_back({a, a, weight});
    entries.push_back({b, b, weight});
    entries.push_back({a, b, -weight});
  }
  for (const StrainTerm& term : elastic.strain_terms) {
    const double modulus =
        2.0 * std::max(term.moduli.mu_pa, 0.0) + 1.5 * std::max(term.moduli.lambda_pa, 0.0);
    for (std::size_t s = 0; s < term.op.domains(); ++s) {
      const double weight = (1.0 + model.strain_damping_s / h) * modulus * term.op.volume_m3[s];
      const auto vertices = term.op.vertices_of(s);
      const auto gradients = term.op.gradients_of(s);
      for (std::size_t i = 0; i < vertices.size(); ++i) {
        for (std::size_t j = 0; j <= i; ++j)
          entries.push_back({vertices[i], vertices[j], weight * dot(gradients[i], gradients[j])});
      }
    }
  }
  for (const TimedLoads& group : model.loads) {
    for (const SupportFace& support : group.loads.supports) {
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j <= i; ++j)
          entries.push_back(
              {support.face[i], support.face[j], support.coefficient_n_per_m * (i == j ? 2.0 : 1.0)});
      }
    }
  }
  return entries;
}

}  // namespace

struct PrefactoredStep::Work {
  Work(const MotionForces& forces, const StepSolverOptions& given)
      : options(given), goal(forces, given), pairs(forces.held_bits().size()) {
    const std::vector<std::uint8_t>& held = forces.held_bits();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::vector<Index>& number = numbers.at(axis);
      number.assign(held.size(), kNoIndex);
      for (std::size_t v = 0; v < held.size(); ++v) {
        if (!is_held(held[v], axis)) number[v] = static_cast<Index>(free.at(axis)++);
      }
      same_as.at(axis) = axis;
      for (std::size_t other = axis; other-- > 0;) {
        if (numbers.at(other) == number) same_as.at(axis) = other;
      }
    }
    for (std::vector<Vec3>* field : {&velocity, &imbalance, &imbalance_before, &change, &before})
      field->resize(held.size());
  }

  /// Without the rows of what is held along each axis.
  void prepare(const MotionModel& model, double h) {
    if (h == step_s) return;
    const std::vector<ScalarEntry> all = build_entries(model, h);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (same_as.at(axis) != axis || free.at(axis) == 0) continue;
      const std::vector<Index>& number = numbers.at(axis);
      std::vector<ScalarEntry> left;
      for (const ScalarEntry& entry : all) {
        if (number[entry.row] != kNoIndex && number[entry.column] != kNoIndex)
          left.push_back({number[entry.row], number[entry.column], entry.value});
      }
      factors.at(axis) = factor_laplace(free.at(axis), left);
    }
    step_s = h;
    pairs.clear();
  }

  /// A^-1 of the free components of `field`, in place; zero in the others.
  void apply_inverse(std::span<Vec3> field) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (same_as.at(axis) != axis) continue;
      const std::vector<Index>& number = numbers.at(axis);
      right.resize(free.at(axis));
      for (std::size_t v = 0; v < number.size(); ++v) {
        if (number[v] != kNoIndex) right[number[v]] = field[v];
      }
      if (free.at(axis) > 0) solve(factors.at(axis), right, scratch, right);
      for (std::size_t v = 0; v < number.size(); ++v) {
        const Vec3 found = number[v] == kNoIndex ? Vec3{} : right[number[v]];
        if (same_as[0] == axis) field[v].x = found.x;
        if (same_as[1] == axis) field[v].y = found.y;
        if (same_as[2] == axis) field[v].z = found.z;
      }
    }
  }

  /// Takes a way along `change`, which began with the slope imbalance . change = `slope`, back to where the
  /// slope is zero, if it falls evenly, as often as it ends well beyond; at a time to `least_cut` of what is
  /// left of it at most. `go_to` moves to a share of the way and looks at what is out of balance, as was done
  /// for all of it. Returns: the share.
  double shorten(double slope, double least_cut, const std::function<void(double)>& go_to) const {
    double share = 1.0;
    for (int tries = 0; tries < kMostTries; ++tries) {
      const double left = dot_of(imbalance, change);
      if (left >= -kTooFar * slope) break;
      share *= std::isfinite(left) ? std::max(slope / (slope - left), least_cut) : kGreatestCut;
      go_to(share);
    }
    return share;
  }

  /// Sets `change` to the way of a vertex from the start of the step to the inertial guess, where free.
  ///
  /// Returns:  imbalance . change at the start in J, but for the forces there: m v . h v / h.
  double take_inertial_way(const MotionForces& forces, const MotionState& state, double h) {
    for (std::size_t v = 0; v < change.size(); ++v) change[v] = h * state.velocity_m_s[v];
    clear_held(forces.held_bits(), change);
    double slope = 0.0;
    for (std::size_t v = 0; v < change.size(); ++v)
      slope += forces.model().mass_kg[v] / (h * h) * dot(change[v], change[v]);
    return slope;
  }

  /// What the correction by `share` of the change has shown of the curvature.
  void keep_pair(double share) {
    for (std::size_t v = 0; v < change.size(); ++v) {
      change[v] = share * change[v];
      imbalance_before[v] = imbalance_before[v] - imbalance[v];
    }
    pairs.keep(change, imbalance_before);
  }

  /// The correction that is tried next, downhill in what is out of balance.
  ///
  /// Returns:  imbalance . change in J.
  double find_change() {
    for (;;) {
      std::copy(imbalance.begin(), imbalance.end(), change.begin());
      pairs.apply(change, [this](std::span<Vec3> field) { apply_inverse(field); });
      const double slope = dot_of(imbalance, change);
      if (slope > 0.0 || pairs.is_empty()) return slope;
      pairs.clear();
    }
  }

  StepSolverOptions options;
  StepGoal goal;
  CurvaturePairs pairs;
  double step_s = 0.0;
  std::size_t steps = 0;
  std::array<std::vector<Index>, 3> numbers;  ///< of the free vertices along each axis
  std::array<std::size_t, 3> free{};
  std::array<std::size_t, 3> same_as{};  ///< an axis with the same free vertices shares its factor
  std::array<LaplaceFactor, 3> factors;
  LaplaceScratch scratch;
  std::vector<Vec3> right;
  std::vector<Vec3> velocity;
  std::vector<Vec3> imbalance;
  std::vector<Vec3> imbalance_before;
  std::vector<Vec3> change;
  std::vector<Vec3> before;
};

PrefactoredStep::PrefactoredStep(const MotionForces& forces, const StepSolverOptions& options)
    : work_(std::make_unique<Work>(forces, options)) {
  if (forces.model().elastic.volume_force)
    throw InputError("integrator", 0, "a model that has an energy for prefactored",
                     "the thesis's volume force");
}

PrefactoredStep::~PrefactoredStep() = default;
PrefactoredStep::PrefactoredStep(PrefactoredStep&&) noexcept = default;
PrefactoredStep& PrefactoredStep::operator=(PrefactoredStep&&) noexcept = default;

ImplicitResult PrefactoredStep::find_displacement(MotionForces& forces, const MotionState& state,
                                                  double step_s, std::span<Vec3> u) {
  Work& work = *work_;
  work.prepare(forces.model(), step_s);
  set_inertial_guess(forces, state, step_s, u);
  ImplicitResult result;
  const double tolerance = work.options.tolerance;
  double residual = 0.0;
  const auto look = [&] {
    result.zero_length_springs += find_imbalance(forces, state, step_s, u, work.velocity, work.imbalance);
    residual = norm_of(work.imbalance);
  };
  // Back to `before`, so far along the change, and a look.
  const auto go_to = [&](double share) {
    std::copy(work.before.begin(), work.before.end(), u.begin());
    add_scaled(u, share, work.change);
    look();
  };
  look();
  const double first = residual;
  // Where inertia does not pay for what forces would stand against at the guess, it is taken back: what few
  // iterations leave of that would be energy gained.
  const double inertia = work.take_inertial_way(forces, state, step_s);
  bool is_shortened = work.shorten(inertia, 0.0, [&](double share) {
    set_inertial_guess(forces, state, step_s, u);
    add_scaled(u, share - 1.0, work.change);
    look();
  }) != 1.0;
  result.solved = false;
  const bool is_looked_at = is_leftover_due(work.steps++);
  while (result.iterations < work.options.iterations) {
    result.solved = work.goal.is_met(residual, first, u, step_s);
    if (result.solved) break;
    const double slope = work.find_change();
    std::copy(u.begin(), u.end(), work.before.begin());
    std::copy(work.imbalance.begin(), work.imbalance.end(), work.imbalance_before.begin());
    add_scaled(u, 1.0, work.change);
    ++result.iterations;
    const bool is_last = result.iterations == work.options.iterations;
    if (tolerance == 0.0 && is_last && !is_looked_at && !is_shortened) break;
    look();
    const double share = work.shorten(slope, kGreatestCut, go_to);
    is_shortened = is_shortened || share != 1.0;
    work.keep_pair(share);
  }
  if (!result.solved) result.solved = tolerance == 0.0 || work.goal.is_met(residual, first, u, step_s);
  if (tolerance > 0.0 || is_looked_at) result.residual_relative = first > 0.0 ? residual / first : 0.0;
  return result;
}

}  // namespace palpate::dynamics

#include "core/dynamics/motion/implicit_step.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/error.h"

namespace palpate::dynamics {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

double component(const Vec3& v, std::size_t axis) {
  return axis == 0 ? v.x : (axis == 1 ? v.y : v.z);
}

void add_to_component(Vec3& v, std::size_t axis, double value) {
  (axis == 0 ? v.x : (axis == 1 ? v.y : v.z)) += value;
}

bool is_held(std::uint8_t bits, std::size_t axis) {
  return ((static_cast<unsigned>(bits) >> axis) & 1U) != 0;
}

/// Velocities that carry held components to where they belong at the end of the step; `velocity` keeps the
/// others.
void set_held_velocity(const MotionForces& forces, const MotionState& state, double step_s,
                       std::span<Vec3> velocity) {
  for (const HeldComponent& held : forces.held()) {
    const double share = value_at(forces.model().loads[held.group].profile, state.time_s + step_s).share;
    const double change = share * held.by_m - component(state.displacement_m[held.vertex], held.axis);
    Vec3& v = velocity[held.vertex];
    add_to_component(v, held.axis, change / step_s - component(v, held.axis));
  }
}

}  // namespace

LinearisedStep::LinearisedStep(const MotionForces& forces, const LinearOptions& options)
    : pattern_(build_motion_pattern(forces.model())),
      constant_(pattern_),
      stiffness_(pattern_),
      system_(pattern_),
      solver_(options),
      force_(forces.held_bits().size()),
      product_(force_.size()),
      change_(force_.size()) {
  add_constant_damping(forces.model(), constant_);
}

ImplicitResult LinearisedStep::find_velocity(MotionForces& forces, const MotionState& state, double step_s,
                                             std::span<Vec3> velocity) {
  const MotionModel& model = forces.model();
  const double h = step_s;
  ImplicitResult result;
  result.zero_length_springs =
      forces.evaluate(state.displacement_m, state.velocity_m_s, state.time_s + h, force_);
  stiffness_.blocks = pattern_.blocks;
  add_motion_stiffness(model, state.displacement_m, TangentKind::kProjected, stiffness_);
  system_.blocks = constant_.blocks;
  add_changing_damping(model, state.displacement_m, system_);
  for (std::size_t k = 0; k < system_.blocks.size(); ++k)
    system_.blocks[k] = h * system_.blocks[k] + (h * h) * stiffness_.blocks[k];
  for (std::size_t v = 0; v < model.mass_kg.size(); ++v)
    add_block(system_, static_cast<Index>(v), static_cast<Index>(v), model.mass_kg[v] * kIdentity);

  multiply(stiffness_, state.velocity_m_s, product_, forces.threads());
  for (std::size_t v = 0; v < force_.size(); ++v) force_[v] = h * (force_[v] - h * product_[v]);
  // What held components are told goes to the right-hand side.
  std::copy(state.velocity_m_s.begin(), state.velocity_m_s.end(), velocity.begin());
  set_held_velocity(forces, state, h, velocity);
  for (std::size_t v = 0; v < force_.size(); ++v) change_[v] = velocity[v] - state.velocity_m_s[v];
  if (!forces.held().empty()) {
    multiply(system_, change_, product_, forces.threads());
    for (std::size_t v = 0; v < force_.size(); ++v) force_[v] = force_[v] - product_[v];
  }
  result.solved = solver_.prepare(system_, forces.held_bits()) == LinearStatus::kSolved;
  const LinearResult solve = solver_.solve(force_, change_);
  result.iterations = solve.iterations;
  result.solved = result.solved && solve.status == LinearStatus::kSolved;
  for (std::size_t v = 0; v < force_.size(); ++v) velocity[v] = velocity[v] + change_[v];
  return result;
}

struct PrefactoredStep::Factors {
  double step_s = 0.0;
  std::array<std::vector<Index>, 3> number;  ///< of the free vertices along each axis
  std::array<std::size_t, 3> free{};
  std::array<std::size_t, 3> same_as{};  ///< an axis with the same free vertices shares its factor
  std::array<Eigen::SimplicialLDLT<Sparse>, 3> factor;
  std::vector<Vec3> u;
  std::vector<Vec3> force;

  void number_free(const std::vector<std::uint8_t>& held) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      number[axis].assign(held.size(), kNoIndex);
      for (std::size_t v = 0; v < held.size(); ++v) {
        if (!is_held(held[v], axis)) number[axis][v] = static_cast<Index>(free[axis]++);
      }
      same_as[axis] = axis;
      for (std::size_t other = axis; other-- > 0;) {
        if (number[other] == number[axis]) same_as[axis] = other;
      }
    }
  }

  /// M / h^2 + gamma / h + Laplacian of k + c / h + supports, of the free vertices of one axis.
  Sparse matrix(const MotionModel& model, std::size_t axis, double h) const {
    std::vector<Eigen::Triplet<double>> entries;
    const std::vector<Index>& place = number[axis];
    const auto add = [&](Index a, Index b, double value) {
      if (place[a] != kNoIndex && place[b] != kNoIndex)
        entries.emplace_back(static_cast<int>(place[a]), static_cast<int>(place[b]), value);
    };
    for (std::size_t v = 0; v < place.size(); ++v) {
      const double drag =
          model.environment_damping_n_s_per_m.empty() ? 0.0 : model.environment_damping_n_s_per_m[v];
      add(static_cast<Index>(v), static_cast<Index>(v), model.mass_kg[v] / (h * h) + drag / h);
    }
    for (std::size_t s = 0; s < model.elastic.springs.springs.size(); ++s) {
      const auto [a, b] = model.elastic.springs.springs[s];
      const double damping = model.spring_damping_n_s_per_m.empty() ? 0.0 : model.spring_damping_n_s_per_m[s];
      const double weight = model.elastic.springs.stiffness_n_per_m[s] + damping / h;
      add(a, a, weight);
      add(b, b, weight);
      add(a, b, -weight);
      add(b, a, -weight);
    }
    for (const TimedLoads& group : model.loads) {
      for (const SupportFace& support : group.loads.supports) {
        for (const Index a : support.face) {
          for (const Index b : support.face) add(a, b, support.coefficient_n_per_m * (a == b ? 2.0 : 1.0));
        }
      }
    }
    Sparse out(static_cast<Eigen::Index>(free[axis]), static_cast<Eigen::Index>(free[axis]));
    out.setFromTriplets(entries.begin(), entries.end());
    return out;
  }

  void prepare(const MotionModel& model, double h) {
    if (h == step_s) return;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (same_as[axis] != axis || free[axis] == 0) continue;
      const Sparse a = matrix(model, axis, h);
      if (step_s == 0.0) factor[axis].analyzePattern(a);
      factor[axis].factorize(a);
    }
    step_s = h;
  }

  /// u += A^-1 force in the free components.
  void correct() {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (free[axis] == 0) continue;
      Eigen::VectorXd rhs(static_cast<Eigen::Index>(free[axis]));
      for (std::size_t v = 0; v < u.size(); ++v) {
        if (number[axis][v] != kNoIndex)
          rhs[static_cast<Eigen::Index>(number[axis][v])] = component(force[v], axis);
      }
      const Eigen::VectorXd change = factor.at(same_as[axis]).solve(rhs);
      for (std::size_t v = 0; v < u.size(); ++v) {
        if (number[axis][v] != kNoIndex)
          add_to_component(u[v], axis, change[static_cast<Eigen::Index>(number[axis][v])]);
      }
    }
  }
};

PrefactoredStep::PrefactoredStep(const MotionForces& forces, std::size_t iterations, double tolerance)
    : factors_(std::make_unique<Factors>()), iterations_(iterations), tolerance_(tolerance) {
  const ElasticModel& elastic = forces.model().elastic;
  if (!elastic.strain_terms.empty() || elastic.volume_force)
    throw InputError("integrator", 0, "a model of springs alone for prefactored", "one with a volume model");
  factors_->number_free(forces.held_bits());
  factors_->u.resize(forces.held_bits().size());
  factors_->force.resize(forces.held_bits().size());
}

PrefactoredStep::~PrefactoredStep() = default;
PrefactoredStep::PrefactoredStep(PrefactoredStep&&) noexcept = default;
PrefactoredStep& PrefactoredStep::operator=(PrefactoredStep&&) noexcept = default;

ImplicitResult PrefactoredStep::find_velocity(MotionForces& forces, const MotionState& state, double step_s,
                                              std::span<Vec3> velocity) {
  const MotionModel& model = forces.model();
  Factors& work = *factors_;
  work.prepare(model, step_s);
  const std::size_t n = velocity.size();
  std::copy(state.velocity_m_s.begin(), state.velocity_m_s.end(), velocity.begin());
  set_held_velocity(forces, state, step_s, velocity);
  for (std::size_t v = 0; v < n; ++v) work.u[v] = state.displacement_m[v] + step_s * velocity[v];
  ImplicitResult result;
  result.solved = false;
  double first = 0.0;
  for (;; ++result.iterations) {
    for (std::size_t v = 0; v < n; ++v) velocity[v] = (1.0 / step_s) * (work.u[v] - state.displacement_m[v]);
    result.zero_length_springs += forces.evaluate(work.u, velocity, state.time_s + step_s, work.force);
    double out_of_balance = 0.0;
    double rounding = 0.0;  // of the inertia, below which no iteration gets
    for (std::size_t v = 0; v < n; ++v) {
      Vec3& f = work.force[v];
      f = f - (model.mass_kg[v] / step_s) * (velocity[v] - state.velocity_m_s[v]);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (!is_held(forces.held_bits()[v], axis)) out_of_balance += component(f, axis) * component(f, axis);
      }
    }
    if (result.iterations == 0) first = out_of_balance;
    result.solved = out_of_balance <= tolerance_ * tolerance_ * first + rounding;
    if (result.solved || result.iterations == iterations_) return result;
    work.correct();
  }
}

}  // namespace palpate::dynamics

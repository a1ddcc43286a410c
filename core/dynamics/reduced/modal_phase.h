// A held body in motion by its lowest modes, while the same loads are there.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/dynamics/finite_elements/node_loads.h"
#include "core/dynamics/motion/time_profile.h"
#include "core/dynamics/reduced/exact_step.h"
#include "core/dynamics/reduced/modal_basis.h"

namespace palpate::dynamics {

/// Loads that follow one profile: dead loads, supports and held faces that are moved.
struct ModalGroup {
  NodeLoads loads;
  TimeProfile profile;
};

/// How many modes, what stands beside them, and Rayleigh's damping by shares.
struct ModalOptions {
  std::size_t modes = 60;
  bool correction = true;  ///< static correction of what the modes leave out of each load
  double damping_stiffness_s = 0.0;
  double damping_mass_per_s = 0.0;
};

/// Displacement and velocity, one vector a node.
struct NodeState {
  std::vector<Vec3> displacement_m;
  std::vector<Vec3> velocity_m_s;
};

/// What is measured at one time.
struct ModalMeasure {
  double kinetic_j = 0.0;
  double elastic_j = 0.0;
  double load_j = 0.0;
  std::vector<Vec3> group_force_n;  ///< of each group on the body: supports, dead loads, and what holds
};

/// M a + (alpha M + beta K) v + (K + S) u = sum over groups of (f + S by) s(t), reduced:
///
///   u = Phi eta + sum over groups of (psi - Phi Phi^T M psi) s(t),    eta = Phi^T M u
///   eta'' + (alpha + beta Phi^T K Phi) eta' + Omega^2 eta = Omega^2 Phi^T M psi s - beta Phi^T K r s'
///
/// Phi the lowest modes of K + S, psi the body at rest under a group's whole load, r the second factor of s
/// in u: the static correction (mode acceleration) of what the modes leave out. Supports don't damp, so the
/// damping couples the modes; the small system is stepped by its exponential all the same.
///
/// Source: R. R. Craig, Structural Dynamics (1981), for mode acceleration; A. Pentland and J. Williams,
///         SIGGRAPH 1989, 215-222; D. L. James and D. K. Pai, SIGGRAPH 2002, 582-585, for modes in real time.
class ModalPhase {
 public:
  /// `body` must outlive it. Throws: InputError if two groups hold one component, or for more modes than the
  /// body has; what `make_factor` throws.
  ModalPhase(const ElementMatrices& body, int order, std::vector<ModalGroup> groups,
             const ModalOptions& options, const FactorMaker& make_factor);
  ~ModalPhase();
  ModalPhase(ModalPhase&&) noexcept;

  /// Takes over a state at a time. Returns the share of its displacement that the modes cannot hold, in the
  /// norm of the mass.
  double start(const NodeState& state, double time_s);
  /// At rest under the shares of the present time.
  void rest();
  /// Makes the exponential of a step; advance() does so too where the step has changed.
  void prepare(double step_s);
  /// One step of `step_s` to `time_s`.
  void advance(double step_s, double time_s);

  ModalMeasure measure() const;
  /// The force of one group on the body, as measure() has it, for a small part of the work.
  Vec3 group_force(std::size_t group) const;
  Vec3 displacement_of(Index node) const;
  NodeState state() const;
  /// Of the first `nodes` alone: nodes x 3 x (modes + groups) products, twice.
  NodeState state_of_first(std::size_t nodes) const;
  /// Their displacements alone.
  std::vector<Vec3> displacements_of_first(std::size_t nodes) const;
  /// Of the modes, in Hz, rising.
  std::vector<double> frequencies_hz() const;
  const std::vector<ModalGroup>& groups() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate::dynamics

// Equilibria of a linear network under one way of holding it, for training: assembled, factored, solved.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/springs/training/training_terms.h"

namespace palpate::springs {

/// The stiffness of the terms and of one boundary, in its free components. What depends on the pattern alone
/// is built once; each factor() takes new constants. `terms` and `boundary` must outlive it.
class NetworkEquilibrium {
 public:
  NetworkEquilibrium(const RankOneTerms& terms, const TrainingBoundary& boundary);
  ~NetworkEquilibrium();
  NetworkEquilibrium(NetworkEquilibrium&&) noexcept;
  NetworkEquilibrium& operator=(NetworkEquilibrium&&) noexcept;

  /// Returns whether the stiffness is positive definite.
  bool factor(std::span<const double> constant);

  /// The equilibrium under `force_n` with the held components at `held_m`.
  std::vector<double> solve(std::span<const double> force_n, std::span<const double> held_m) const;

  /// The solution for a right-hand side whose held components are left out; zero in those.
  std::vector<double> solve_adjoint(std::span<const double> rhs) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace palpate::springs

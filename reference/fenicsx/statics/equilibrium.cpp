#include "reference/fenicsx/statics/equilibrium.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/mesh/topology.h"

namespace palpate::reference::fenicsx {
namespace {

double norm_of(const Vector& v) {
  PetscReal value = 0.0;
  check(VecNorm(v.get(), NORM_2, &value), "VecNorm");
  return value;
}

double dot_of(const Vector& a, const Vector& b) {
  PetscScalar value = 0.0;
  check(VecDot(a.get(), b.get(), &value), "VecDot");
  return value;
}

/// u + share x step, with ghosts.
Vector moved(const Vector& u, double share, const Vector& step) {
  Vector made = zeros_like(u);
  check(VecWAXPY(made.get(), share, step.get(), u.get()), "VecWAXPY");
  update_ghosts(made);
  return made;
}

/// The body with all that acts on it.
class LoadedBody {
 public:
  LoadedBody(const TetMesh& mesh, const BoundaryProblem& problem, ElasticBody& body)
      : body_(body), terms_(mesh, problem, body), load_(body.create_vector()) {
    body.add_body_force(problem.material.density_kg_m3 * problem.gravity_m_s2, load_);
    if (!problem.body_force_n_m3.empty()) {
      body.add_body_force_field(problem.body_force_n_m3, build_edges(mesh), load_);
    }
    terms_.add_loads(load_);
    add_up_ghosts(load_);
    update_ghosts(load_);
  }

  const BoundaryTerms& terms() const { return terms_; }

  /// Stored energy, plus that of the supports, less the work of the share `factor` of the loads.
  double total_energy(const Vector& u, double factor) const {
    PetscScalar work = 0.0;
    check(VecDot(load_.get(), u.get(), &work), "VecDot");
    return body_.stored_energy(u) + terms_.support_energy(u, factor) - factor * work;
  }

  /// The force that is out of balance at `u` under the share `factor` of all loads; 0 at held entries.
  Vector residual(const Vector& u, double factor) const {
    Vector internal = body_.create_vector();
    body_.add_internal_force(u, internal);
    {
      const LocalEntries entries(internal.get());
      for (PetscScalar& entry : entries.get()) entry = -entry;
    }
    terms_.add_support_force(u, factor, internal);
    add_up_ghosts(internal);
    check(VecAXPY(internal.get(), factor, load_.get()), "VecAXPY");
    update_ghosts(internal);
    terms_.clear_held(internal);
    return internal;
  }

 private:
  ElasticBody& body_;
  BoundaryTerms terms_;
  Vector load_;
};

/// Newton's method, load step by load step.
class LoadStepping {
 public:
  LoadStepping(const LoadedBody& loaded, TangentSystem& system, const EquilibriumOptions& options,
               Equilibrium& found)
      : loaded_(loaded), system_(system), options_(options), found_(found) {}

  /// Goes from no load to all of it. Returns whether it got there.
  bool run() {
    double reached = 0.0;
    double step = 1.0;
    while (reached < 1.0) {
      const double factor = step >= 1.0 - reached ? 1.0 : reached + step;
      Vector before = moved(found_.displacement, 0.0, found_.displacement);
      if (reach(reached, factor)) {
        reached = factor;
        step *= 2.0;
        ++found_.load_steps;
      } else {
        found_.displacement = std::move(before);
        step = 0.5 * (factor - reached);
        if (step < options_.least_load_step) return false;
      }
    }
    return true;
  }

 private:
  /// Equilibrium under the share `factor` of the load, from that under `reached`.
  bool reach(double reached, double factor) {
    const double tolerance = factor == 1.0 ? options_.tolerance_relative : kTolerancePartWay;
    bool holding = loaded_.terms().is_anything_moved();  // the first step takes the held entries along
    for (int k = 0; k < options_.most_newton_steps; ++k) {
      const Vector residual = loaded_.residual(found_.displacement, factor);
      const double left_over = norm_of(residual);
      found_.residual_relative = reference_n_ > 0.0 ? left_over / reference_n_ : 0.0;
      if (k > 0 && left_over <= tolerance * reference_n_) return true;
      Vector step = zeros_like(residual);
      if (holding) loaded_.terms().set_held(factor - reached, step);
      const LinearReport report = system_.solve(found_.displacement, residual, inner_tolerance(k), step);
      ++found_.newton_steps;
      found_.linear_iterations += report.iterations;
      if (reference_n_ == 0.0) reference_n_ = report.right_side_norm;
      if (reference_n_ == 0.0) return true;  // nothing acts on the body
      if (!report.converged) return false;
      if (!(holding ? take(step, factor) : search(residual, step, factor))) return false;
      holding = false;
    }
    return false;
  }

  /// No more exact than the step deserves: Newton's error falls as its square.
  double inner_tolerance(int k) const {
    if (k == 0) return 1e-4;
    const double left = found_.residual_relative;
    return std::clamp(left, std::min(1e-3, 0.1 * options_.tolerance_relative / left), 1e-3);
  }

  /// The whole step, if no tet turns inside out.
  bool take(const Vector& step, double factor) {
    Vector there = moved(found_.displacement, 1.0, step);
    if (!std::isfinite(loaded_.total_energy(there, factor))) return false;
    found_.displacement = std::move(there);
    return true;
  }

  /// The largest of the shares 1, 1/2, 1/4 ... of the step that lowers the total energy enough.
  bool search(const Vector& residual, const Vector& step, double factor) {
    const double before = loaded_.total_energy(found_.displacement, factor);
    const double slope = dot_of(residual, step);
    if (!(slope > 0.0)) return false;  // no way down: the body is about to buckle
    double share = 1.0;
    for (int k = 0; k < kMostShares; ++k, share *= 0.5) {
      Vector there = moved(found_.displacement, share, step);
      const double energy = loaded_.total_energy(there, factor);
      const bool lower = energy <= before - kArmijo * share * slope;
      const bool below_rounding = std::isfinite(energy) && slope <= kRounding * std::abs(before);
      if (!lower && !below_rounding) continue;
      found_.displacement = std::move(there);
      return true;
    }
    return false;
  }

  static constexpr double kTolerancePartWay = 1e-4;
  static constexpr double kArmijo = 1e-4;
  static constexpr double kRounding = 1e-10;  ///< share of the energy below which a change cannot be told
  static constexpr int kMostShares = 12;

  const LoadedBody& loaded_;
  TangentSystem& system_;
  const EquilibriumOptions& options_;
  Equilibrium& found_;
  double reference_n_ = 0.0;  ///< what is out of balance in the undeformed body under all load
};

/// Small strain.
bool solve_once(const LoadedBody& loaded, TangentSystem& system, double tolerance_relative,
                Equilibrium& found) {
  Vector step = zeros_like(found.displacement);
  loaded.terms().set_held(1.0, step);
  const Vector residual = loaded.residual(found.displacement, 1.0);
  const LinearReport report = system.solve(found.displacement, residual, tolerance_relative, step);
  found.displacement = std::move(step);
  found.linear_iterations = report.iterations;
  found.newton_steps = found.load_steps = 1;
  found.residual_relative = report.residual_relative;
  return report.converged;
}

/// Solves for one problem with a system that may be in use for others.
Equilibrium solve_loaded(const BoundaryProblem& problem, const LoadedBody& loaded, ElasticBody& body,
                         TangentSystem& system, const EquilibriumOptions& options) {
  const Stopwatch watch;
  const double solve_before = system.solve_s();
  Equilibrium found;
  found.displacement = body.create_vector();
  const bool converged = problem.strain == StrainSize::kSmall
                             ? solve_once(loaded, system, options.tolerance_relative, found)
                             : LoadStepping(loaded, system, options, found).run();
  found.outcome = converged ? "converged" : "not_converged";
  found.solver = system.name();
  found.strain_energy_j = body.stored_energy(found.displacement);
  found.support_energy_j = loaded.terms().support_energy(found.displacement, 1.0);
  found.support_forces_n = loaded.terms().support_forces(found.displacement, 1.0);
  found.solve_s = system.solve_s() - solve_before;
  found.assembly_s = watch.seconds() - found.solve_s;
  return found;
}

bool is_still(const HeldFaces& held) {
  return length_sq(held.by_m) == 0.0;
}

bool are_same(const FacePatch& a, const FacePatch& b) {
  return a.faces == b.faces && a.weight == b.weight;
}

}  // namespace

bool share_stiffness(const BoundaryProblem& a, const BoundaryProblem& b) {
  const auto same_held = [](const HeldFaces& x, const HeldFaces& y) {
    return x.faces == y.faces && x.axes == y.axes && is_still(x) && is_still(y);
  };
  const auto same_support = [](const ElasticSupport& x, const ElasticSupport& y) {
    return are_same(x.patch, y.patch) && x.stiffness_pa_per_m == y.stiffness_pa_per_m;
  };
  return a.strain == StrainSize::kSmall && b.strain == StrainSize::kSmall && a.held_field_m.empty() &&
         b.held_field_m.empty() && a.material.young_modulus_pa == b.material.young_modulus_pa &&
         a.material.poisson_ratio == b.material.poisson_ratio &&
         std::equal(a.held.begin(), a.held.end(), b.held.begin(), b.held.end(), same_held) &&
         std::equal(a.supports.begin(), a.supports.end(), b.supports.begin(), b.supports.end(), same_support);
}

std::vector<Equilibrium> find_equilibria(const TetMesh& mesh, std::span<const BoundaryProblem> problems,
                                         ElasticBody& body, const EquilibriumOptions& options) {
  const Stopwatch watch;
  const LoadedBody first(mesh, problems.front(), body);
  TangentSystem system(mesh, problems.front(), body, first.terms(), options.solver);
  const double setup_s = watch.seconds();
  std::vector<Equilibrium> found;
  found.push_back(solve_loaded(problems.front(), first, body, system, options));
  found.front().assembly_s += setup_s;
  for (const BoundaryProblem& problem : problems.subspan(1)) {
    require(share_stiffness(problems.front(), problem), "find_equilibria: problems of different stiffness");
    found.push_back(solve_loaded(problem, LoadedBody(mesh, problem, body), body, system, options));
  }
  return found;
}

}  // namespace palpate::reference::fenicsx

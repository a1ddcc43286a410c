#include "reference/fenicsx/equilibrium.h"

#include <chrono>
#include <cmath>

#include "core/mesh/topology.h"

namespace palpate::reference::fenicsx {
namespace {

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

}  // namespace

Equilibrium find_equilibrium(const TetMesh& mesh, const BoundaryProblem& problem, ElasticBody& body,
                             const EquilibriumOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  const LoadedBody loaded(mesh, problem, body);
  TangentSystem system(mesh, problem, body, loaded.terms(), options.solver);
  Equilibrium found;
  found.displacement = body.create_vector();
  Vector step = body.create_vector();
  loaded.terms().set_held(1.0, step);
  const Vector residual = loaded.residual(found.displacement, 1.0);
  const LinearReport report = system.solve(found.displacement, residual, options.tolerance_relative, step);
  check(VecCopy(step.get(), found.displacement.get()), "VecCopy");
  update_ghosts(found.displacement);
  found.outcome = report.converged ? "converged" : "not_converged";
  found.solver = system.name();
  found.linear_iterations = report.iterations;
  found.residual_relative = report.residual_relative;
  found.strain_energy_j = body.stored_energy(found.displacement);
  found.support_energy_j = loaded.terms().support_energy(found.displacement, 1.0);
  found.solve_s = system.solve_s();
  found.assembly_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() - found.solve_s;
  return found;
}

}  // namespace palpate::reference::fenicsx

#include "reference/fenicsx/motion/frequencies.h"

#include <slepceps.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "core/base/error.h"
#include "core/mesh/geometry.h"

namespace palpate::reference::fenicsx {
namespace {

using EigenSolver = Handle<EPS, EPSDestroy>;

/// A shift below zero and far below the first elastic omega^2: a hundredth of that of a wave over the box.
double choose_shift(const TetMesh& mesh, const Material& material) {
  const BoundingBox box = bounding_box(mesh.points);
  return -0.01 * material.young_modulus_pa / (material.density_kg_m3 * length_sq(box.high - box.low));
}

void set_up(const EigenSolver& solver, double shift, PetscInt count) {
  EPS eps = solver.get();
  check(EPSSetProblemType(eps, EPS_GHEP), "EPSSetProblemType");
  check(EPSSetType(eps, EPSKRYLOVSCHUR), "EPSSetType");
  check(EPSSetDimensions(eps, count, PETSC_DEFAULT, PETSC_DEFAULT), "EPSSetDimensions");
  check(EPSSetTolerances(eps, 1e-9, 500), "EPSSetTolerances");
  check(EPSSetTarget(eps, shift), "EPSSetTarget");
  check(EPSSetWhichEigenpairs(eps, EPS_TARGET_MAGNITUDE), "EPSSetWhichEigenpairs");
  ST transform = nullptr;
  check(EPSGetST(eps, &transform), "EPSGetST");
  check(STSetType(transform, STSINVERT), "STSetType");
  check(STSetMatStructure(transform, SAME_NONZERO_PATTERN), "STSetMatStructure");
  KSP linear = nullptr;
  check(STGetKSP(transform, &linear), "STGetKSP");
  check(KSPSetType(linear, KSPPREONLY), "KSPPREONLY");
  PC factors = nullptr;
  check(KSPGetPC(linear, &factors), "KSPGetPC");
  check(PCSetType(factors, PCCHOLESKY), "PCCHOLESKY");
  check(PCFactorSetMatSolverType(factors, MATSOLVERMUMPS), "MUMPS");
}

}  // namespace

std::vector<double> find_frequencies(const TetMesh& mesh, const MotionProblem& problem, ElasticBody& body,
                                     std::size_t count) {
  if (problem.body.strain != StrainSize::kSmall)
    throw InputError("strain", 0, "small: frequencies are those of linear elasticity", "large");
  const MovingBody moving(mesh, problem, body, "aij");
  const std::vector<std::size_t> groups = moving.groups_of(find_phases(problem).back());
  const std::vector<PetscInt> held = moving.held_rows(groups);
  if (count + held.size() > 3 * body.global_nodes())
    throw InputError("frequencies", 0, "no more than the body has", std::to_string(count));
  const Matrix stiffness = moving.stiffness_with(groups);
  Matrix mass;
  check(MatDuplicate(moving.mass().get(), MAT_COPY_VALUES, mass.put()), "MatDuplicate");
  const auto rows = static_cast<PetscInt>(held.size());
  check(MatZeroRowsColumns(stiffness.get(), rows, held.data(), 1.0, nullptr, nullptr), "MatZeroRowsColumns");
  check(MatZeroRowsColumns(mass.get(), rows, held.data(), 0.0, nullptr, nullptr), "MatZeroRowsColumns");

  EigenSolver solver;
  check(EPSCreate(PETSC_COMM_WORLD, solver.put()), "EPSCreate");
  check(EPSSetOperators(solver.get(), stiffness.get(), mass.get()), "EPSSetOperators");
  set_up(solver, choose_shift(mesh, problem.body.material), static_cast<PetscInt>(count));
  check(EPSSolve(solver.get()), "EPSSolve");
  PetscInt found = 0;
  check(EPSGetConverged(solver.get(), &found), "EPSGetConverged");
  if (found < static_cast<PetscInt>(count))
    throw std::runtime_error("only " + std::to_string(found) + " of " + std::to_string(count) +
                             " frequencies converged");
  std::vector<double> frequencies;
  for (PetscInt k = 0; k < found; ++k) {
    PetscScalar value = 0.0;
    check(EPSGetEigenvalue(solver.get(), k, &value, nullptr), "EPSGetEigenvalue");
    frequencies.push_back(std::sqrt(std::max(value, 0.0)) / (2.0 * std::numbers::pi));
  }
  std::sort(frequencies.begin(), frequencies.end());
  frequencies.resize(count);
  return frequencies;
}

}  // namespace palpate::reference::fenicsx

#include "reference/fenicsx/statics/linear_solver.h"

#include <unordered_map>

#include "core/base/stopwatch.h"
#include "reference/fenicsx/statics/rigid_motions.h"

namespace palpate::reference::fenicsx {
namespace {

// Where factors and multigrid take about the same time (a kidney, Poisson's ratio 0.45); quadratic shapes
// fill in more.
constexpr std::size_t kMostNodesForMumps = 12000;
constexpr std::size_t kMostQuadraticNodesForMumps = 4000;
constexpr int kMostIterations = 1000;
// No solver does better than this share of |A| |x|, whatever the tolerance.
constexpr double kRounding = 1e-15;
// The residual that conjugate gradients update drifts from the true one where |A| |x| is far above |b| (a
// slender body that bends): they start anew from the true one as long as that pays.
constexpr int kMostStarts = 6;
constexpr double kWorthAStart = 0.5;

/// The interpolation from linear to quadratic shapes: a midpoint takes half of each end of its edge.
Matrix build_interpolation(const ElasticBody& fine, const ElasticBody& coarse) {
  std::unordered_map<Index, PetscInt> column_of;
  for (std::size_t node = 0; node < coarse.nodes().size(); ++node)
    column_of.emplace(coarse.nodes()[node][0], coarse.global_numbers()[node]);
  Matrix scalar;
  check(MatCreateAIJ(PETSC_COMM_WORLD, static_cast<PetscInt>(fine.owned_nodes()),
                     static_cast<PetscInt>(coarse.owned_nodes()), PETSC_DETERMINE, PETSC_DETERMINE, 2,
                     nullptr, 2, nullptr, scalar.put()),
        "MatCreateAIJ");
  for (std::size_t node = 0; node < fine.owned_nodes(); ++node) {
    const auto [a, b] = fine.nodes()[node];
    const PetscInt row = fine.global_numbers()[node];
    for (const Index end : {a, b})
      check(MatSetValue(scalar.get(), row, column_of.at(end), 0.5, ADD_VALUES), "MatSetValue");
  }
  check(MatAssemblyBegin(scalar.get(), MAT_FINAL_ASSEMBLY), "MatAssembly");
  check(MatAssemblyEnd(scalar.get(), MAT_FINAL_ASSEMBLY), "MatAssembly");
  Matrix made;
  check(MatCreateMAIJ(scalar.get(), 3, made.put()), "MatCreateMAIJ");
  return made;
}

void use_mumps(PC preconditioner) {
  check(PCSetType(preconditioner, PCCHOLESKY), "PCCHOLESKY");
  check(PCFactorSetMatSolverType(preconditioner, MATSOLVERMUMPS), "MUMPS");
}

}  // namespace

TangentSystem::TangentSystem(const TetMesh& mesh, const BoundaryProblem& problem, ElasticBody& body,
                             const BoundaryTerms& terms, SolverChoice choice)
    : small_(problem.strain == StrainSize::kSmall) {
  const Stopwatch watch;
  const bool quadratic = body.global_nodes() > mesh.points.size();
  if (choice == SolverChoice::kAuto) {
    const std::size_t most = quadratic ? kMostQuadraticNodesForMumps : kMostNodesForMumps;
    choice = body.global_nodes() <= most ? SolverChoice::kMumps : SolverChoice::kGamg;
  }
  const bool by_linear = quadratic && choice == SolverChoice::kGamg;
  name_ = choice == SolverChoice::kMumps ? "mumps" : by_linear ? "p-multigrid + gamg" : "gamg";
  fine_ = {&body, &terms, body.create_matrix(by_linear ? "baij" : "aij"), body.create_vector()};
  if (by_linear) create_coarse_level(mesh, problem);
  create_solver(mesh);
  assembly_s_ += watch.seconds();
}

TangentSystem::~TangentSystem() = default;

void TangentSystem::create_coarse_level(const TetMesh& mesh, const BoundaryProblem& problem) {
  const ElasticBody& body = *fine_.body;
  coarse_body_ = body.with_linear_shapes();
  coarse_terms_ = std::make_unique<BoundaryTerms>(mesh, problem, *coarse_body_);
  coarse_ = {coarse_body_.get(), coarse_terms_.get(), coarse_body_->create_matrix("aij"),
             coarse_body_->create_vector()};
  interpolation_ = build_interpolation(body, *coarse_body_);
  std::unordered_map<Index, std::size_t> fine_at;
  for (std::size_t node = 0; node < body.nodes().size(); ++node) {
    if (body.nodes()[node][0] == body.nodes()[node][1]) fine_at.emplace(body.nodes()[node][0], node);
  }
  for (std::size_t node = 0; node < coarse_body_->nodes().size(); ++node)
    same_node_.emplace_back(node, fine_at.at(coarse_body_->nodes()[node][0]));
}

void TangentSystem::create_solver(const TetMesh& mesh) {
  check(KSPCreate(PETSC_COMM_WORLD, solver_.put()), "KSPCreate");
  KSP ksp = solver_.get();
  check(KSPSetOptionsPrefix(ksp, "palpate_"), "KSPSetOptionsPrefix");
  PC preconditioner = nullptr;
  check(KSPGetPC(ksp, &preconditioner), "KSPGetPC");
  if (name_ == "mumps") {
    check(KSPSetType(ksp, KSPPREONLY), "KSPPREONLY");
    use_mumps(preconditioner);
  } else {
    check(KSPSetType(ksp, KSPCG), "KSPCG");
    check(KSPSetNormType(ksp, KSP_NORM_UNPRECONDITIONED), "KSPSetNormType");
    rigid_motions_ = near_null_space(mesh, coarse_body_ ? *coarse_body_ : *fine_.body);
    const Matrix& algebraic = coarse_body_ ? coarse_.tangent : fine_.tangent;
    check(MatSetNearNullSpace(algebraic.get(), rigid_motions_.get()), "MatSetNearNullSpace");
    if (coarse_body_) {
      create_multigrid();
    } else {
      check(PCSetType(preconditioner, PCGAMG), "PCGAMG");
    }
  }
  check(KSPSetOperators(ksp, fine_.tangent.get(), fine_.tangent.get()), "KSPSetOperators");
  check(KSPSetFromOptions(ksp), "KSPSetFromOptions");
}

void TangentSystem::create_multigrid() {
  PC preconditioner = nullptr;
  check(KSPGetPC(solver_.get(), &preconditioner), "KSPGetPC");
  check(PCSetType(preconditioner, PCMG), "PCMG");
  check(PCMGSetLevels(preconditioner, 2, nullptr), "PCMGSetLevels");
  check(PCMGSetInterpolation(preconditioner, 1, interpolation_.get()), "PCMGSetInterpolation");
  KSP smoother = nullptr;
  check(PCMGGetSmoother(preconditioner, 1, &smoother), "PCMGGetSmoother");
  check(KSPSetOperators(smoother, fine_.tangent.get(), fine_.tangent.get()), "KSPSetOperators");
  check(KSPSetType(smoother, KSPCHEBYSHEV), "KSPCHEBYSHEV");
  PC smoothing = nullptr;
  check(KSPGetPC(smoother, &smoothing), "KSPGetPC");
  check(PCSetType(smoothing, PCPBJACOBI), "PCPBJACOBI");
  KSP coarse = nullptr;
  check(PCMGGetCoarseSolve(preconditioner, &coarse), "PCMGGetCoarseSolve");
  check(KSPSetOperators(coarse, coarse_.tangent.get(), coarse_.tangent.get()), "KSPSetOperators");
  check(KSPSetType(coarse, KSPPREONLY), "KSPPREONLY");
  PC below = nullptr;
  check(KSPGetPC(coarse, &below), "KSPGetPC");
  check(PCSetType(below, PCGAMG), "PCGAMG");
}

void TangentSystem::assemble(Level& level, const Vector& u, bool definite) const {
  Mat tangent = level.tangent.get();
  check(MatZeroEntries(tangent), "MatZeroEntries");
  level.body->add_tangent(u, level.tangent);
  level.terms->add_supports(level.tangent);
  check(MatAssemblyBegin(tangent, MAT_FINAL_ASSEMBLY), "MatAssembly");
  check(MatAssemblyEnd(tangent, MAT_FINAL_ASSEMBLY), "MatAssembly");
  check(MatSetOption(tangent, MAT_KEEP_NONZERO_PATTERN, PETSC_TRUE), "MatSetOption");
  check(MatSetOption(tangent, MAT_SYMMETRIC, PETSC_TRUE), "MatSetOption");
  if (definite && name_ == "mumps") check(MatSetOption(tangent, MAT_SPD, PETSC_TRUE), "MatSetOption");
}

void TangentSystem::hold(Level& level) const {
  Vector diagonal = zeros_like(level.displacement);
  check(MatGetDiagonal(level.tangent.get(), diagonal.get()), "MatGetDiagonal");
  PetscReal sum = 0.0;
  check(VecNorm(diagonal.get(), NORM_1, &sum), "VecNorm");
  const std::vector<PetscInt>& rows = level.terms->held_rows();
  check(MatZeroRowsColumns(level.tangent.get(), static_cast<PetscInt>(rows.size()), rows.data(),
                           sum / static_cast<double>(3 * level.body->global_nodes()), nullptr, nullptr),
        "MatZeroRowsColumns");
}

void TangentSystem::restrict_displacement(const Vector& u) {
  const LocalEntries from(u.get());
  const LocalEntries to(coarse_.displacement.get());
  for (const auto& [coarse, fine] : same_node_) {
    for (std::size_t axis = 0; axis < 3; ++axis) to[3 * coarse + axis] = from[3 * fine + axis];
  }
}

LinearReport TangentSystem::examine(const Vector& right, const Vector& step, double tolerance_relative,
                                    const Vector& left_over) const {
  LinearReport report;
  check(MatMult(fine_.tangent.get(), step.get(), left_over.get()), "MatMult");
  check(VecAYPX(left_over.get(), -1.0, right.get()), "VecAYPX");
  PetscReal left_over_norm = 0.0;
  PetscReal step_norm = 0.0;
  PetscReal matrix_norm = 0.0;
  check(VecNorm(left_over.get(), NORM_2, &left_over_norm), "VecNorm");
  check(VecNorm(right.get(), NORM_2, &report.right_side_norm), "VecNorm");
  check(VecNorm(step.get(), NORM_2, &step_norm), "VecNorm");
  check(MatNorm(fine_.tangent.get(), NORM_FROBENIUS, &matrix_norm), "MatNorm");
  if (report.right_side_norm > 0.0) report.residual_relative = left_over_norm / report.right_side_norm;
  report.converged =
      report.residual_relative <= tolerance_relative || left_over_norm <= kRounding * matrix_norm * step_norm;
  return report;
}

LinearReport TangentSystem::solve_assembled(const Vector& right, double tolerance_relative,
                                            const Vector& step) const {
  Vector left_over = zeros_like(right);
  Vector correction = zeros_like(right);
  check(VecCopy(right.get(), left_over.get()), "VecCopy");
  LinearReport report;
  int iterations = 0;
  for (int start = 0; start < kMostStarts; ++start) {
    const double wanted = start == 0 ? tolerance_relative : tolerance_relative / report.residual_relative;
    check(KSPSetTolerances(solver_.get(), 0.5 * wanted, 1e-300, PETSC_DEFAULT, kMostIterations),
          "KSPSetTolerances");
    check(KSPSolve(solver_.get(), left_over.get(), correction.get()), "KSPSolve");
    fine_.terms->clear_held(correction);  // multigrid leaves some of its tolerance there
    KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
    check(KSPGetConvergedReason(solver_.get(), &reason), "KSPGetConvergedReason");
    PetscInt done = 0;
    check(KSPGetIterationNumber(solver_.get(), &done), "KSPGetIterationNumber");
    iterations += static_cast<int>(done);
    check(VecAXPY(step.get(), 1.0, correction.get()), "VecAXPY");
    const double before = report.residual_relative;
    report = examine(right, step, tolerance_relative, left_over);
    if (reason <= 0) report.converged = false;
    const bool pays = start == 0 || report.residual_relative <= kWorthAStart * before;
    if (report.converged || reason <= 0 || !pays) break;
  }
  report.iterations = iterations;
  return report;
}

LinearReport TangentSystem::solve(const Vector& u, const Vector& residual, double tolerance_relative,
                                  const Vector& step) {
  const Stopwatch watch;
  const bool is_new = !is_ready_;
  if (is_new) assemble(fine_, u, small_);
  Vector right = zeros_like(residual);
  check(MatMult(fine_.tangent.get(), step.get(), right.get()), "MatMult");
  check(VecAYPX(right.get(), -1.0, residual.get()), "VecAYPX");
  fine_.terms->clear_held(right);
  if (is_new) hold(fine_);
  if (is_new && coarse_body_) {
    restrict_displacement(u);
    assemble(coarse_, coarse_.displacement, small_);
    hold(coarse_);
  }
  is_ready_ = small_;
  assembly_s_ += watch.seconds();

  const Stopwatch solve_watch;
  if (is_new)
    check(KSPSetOperators(solver_.get(), fine_.tangent.get(), fine_.tangent.get()), "KSPSetOperators");
  Vector free_step = zeros_like(residual);
  const LinearReport report = solve_assembled(right, tolerance_relative, free_step);
  update_ghosts(free_step);
  check(VecAXPY(step.get(), 1.0, free_step.get()), "VecAXPY");
  update_ghosts(step);
  solve_s_ += solve_watch.seconds();
  return report;
}

}  // namespace palpate::reference::fenicsx

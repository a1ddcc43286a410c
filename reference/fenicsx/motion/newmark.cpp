#include "reference/fenicsx/motion/newmark.h"

#include <cmath>

#include "core/base/error.h"
#include "core/base/stopwatch.h"

namespace palpate::reference::fenicsx {
namespace {

constexpr double kBeta = 0.25;
constexpr double kGamma = 0.5;
constexpr int kMostIterations = 5000;
// Where a solution with given factors takes as long as one by conjugate gradients.
constexpr std::size_t kMostNodesForMumps = 40000;
constexpr double kMostSteps = 1e8;

double norm_of(const Vector& v) {
  PetscReal value = 0.0;
  check(VecNorm(v.get(), NORM_2, &value), "VecNorm");
  return value;
}

void add_to(const Vector& y, double factor, const Vector& x) {
  check(VecAXPY(y.get(), factor, x.get()), "VecAXPY");
}

/// One linear system, for many right-hand sides.
class StepSystem {
 public:
  StepSystem(Matrix matrix, const std::vector<PetscInt>& held, bool direct) : matrix_(std::move(matrix)) {
    check(MatZeroRowsColumns(matrix_.get(), static_cast<PetscInt>(held.size()), held.data(), 1.0, nullptr,
                             nullptr),
          "MatZeroRowsColumns");
    check(KSPCreate(PETSC_COMM_WORLD, solver_.put()), "KSPCreate");
    PC preconditioner = nullptr;
    check(KSPGetPC(solver_.get(), &preconditioner), "KSPGetPC");
    if (direct) {
      check(MatSetOption(matrix_.get(), MAT_SPD, PETSC_TRUE), "MatSetOption");
      check(KSPSetType(solver_.get(), KSPPREONLY), "KSPPREONLY");
      check(PCSetType(preconditioner, PCCHOLESKY), "PCCHOLESKY");
      check(PCFactorSetMatSolverType(preconditioner, MATSOLVERMUMPS), "MUMPS");
    } else {
      check(KSPSetType(solver_.get(), KSPCG), "KSPCG");
      check(KSPSetNormType(solver_.get(), KSP_NORM_UNPRECONDITIONED), "KSPSetNormType");
      check(KSPSetInitialGuessNonzero(solver_.get(), PETSC_TRUE), "KSPSetInitialGuessNonzero");
      check(PCSetType(preconditioner, PCPBJACOBI), "PCPBJACOBI");
    }
    check(KSPSetOperators(solver_.get(), matrix_.get(), matrix_.get()), "KSPSetOperators");
  }

  /// Solves for `x`, which holds a guess. Returns the residual over that of x = 0.
  double solve(const Vector& right, double tolerance_relative, const Vector& x, Motion& found) {
    check(KSPSetTolerances(solver_.get(), 0.5 * tolerance_relative, 1e-300, PETSC_DEFAULT, kMostIterations),
          "KSPSetTolerances");
    check(KSPSolve(solver_.get(), right.get(), x.get()), "KSPSolve");
    PetscInt done = 0;
    check(KSPGetIterationNumber(solver_.get(), &done), "KSPGetIterationNumber");
    found.linear_iterations += static_cast<std::uint64_t>(done);
    Vector left = zeros_like(right);
    check(MatMult(matrix_.get(), x.get(), left.get()), "MatMult");
    add_to(left, -1.0, right);
    const double size = norm_of(right);
    return size > 0.0 ? norm_of(left) / size : 0.0;
  }

 private:
  Matrix matrix_;
  Solver solver_;
};

/// Takes a body through its phases.
class Stepping {
 public:
  Stepping(const MovingBody& moving, const NewmarkOptions& options, bool direct, Motion& found)
      : moving_(moving), options_(options), direct_(direct), found_(found) {
    const ElasticBody& body = moving.body();
    state_ = {0.0, body.create_vector(), body.create_vector(), body.create_vector()};
  }

  /// Whether all steps converged.
  bool run() {
    const std::vector<LoadPhase> phases = find_phases(moving_.problem());
    double steps = 0.0;
    for (const LoadPhase& phase : phases) steps += steps_of(phase);
    if (!(steps <= kMostSteps))
      throw InputError("time_step_s", 0, "at most 1e8 steps", std::to_string(steps));
    stride_ = static_cast<std::uint64_t>(
        std::ceil(steps / static_cast<double>(moving_.problem().samples) * (1.0 - 1e-12)));
    bool converged = true;
    for (std::size_t k = 0; k < phases.size() && converged; ++k)
      converged = run_phase(phases[k], k == 0, k + 1 == phases.size());
    return converged;
  }

 private:
  double steps_of(const LoadPhase& phase) const {
    return std::ceil((phase.to_s - phase.from_s) / options_.time_step_s * (1.0 - 1e-12));
  }

  bool run_phase(const LoadPhase& phase, bool is_first, bool is_last) {
    groups_ = moving_.groups_of(phase);
    held_ = moving_.held_rows(groups_);
    const auto steps = static_cast<std::uint64_t>(steps_of(phase));
    const double h = (phase.to_s - phase.from_s) / static_cast<double>(steps);
    found_.time_step_s = std::max(found_.time_step_s, h);
    if (!start(phase.from_s)) return false;
    if (is_first) add_row();
    StepSystem system(build_matrix(h), held_, direct_);
    for (std::uint64_t k = 1; k <= steps; ++k) {
      state_.time_s = k == steps ? phase.to_s : phase.from_s + static_cast<double>(k) * h;
      if (!step(system, h)) return false;
      ++found_.steps;
      if (found_.steps % stride_ == 0 || (is_last && k == steps)) add_row();
    }
    return true;
  }

  void add_row() {
    found_.history.rows.push_back(moving_.measure(groups_, state_));
    if (found_.states.is_due(state_.time_s)) found_.states.add(state_.time_s, moving_.at_vertices(state_));
  }

  /// M (1 + gamma h alpha) + K h (gamma beta + h / 4) + supports h^2 / 4.
  Matrix build_matrix(double h) const {
    const MotionProblem& problem = moving_.problem();
    Matrix made = moving_.stiffness_with(groups_);
    check(MatScale(made.get(), kBeta * h * h), "MatScale");
    check(MatAXPY(made.get(), kGamma * h * problem.damping_stiffness_s, moving_.stiffness().get(),
                  SAME_NONZERO_PATTERN),
          "MatAXPY");
    check(MatAXPY(made.get(), 1.0 + kGamma * h * problem.damping_mass_per_s, moving_.mass().get(),
                  SAME_NONZERO_PATTERN),
          "MatAXPY");
    return made;
  }

  /// The acceleration at the start of a phase, from M a = f - C v - K u.
  bool start(double time_s) {
    state_.time_s = time_s;
    check(VecZeroEntries(state_.acceleration.get()), "VecZeroEntries");
    moving_.impose(groups_, state_);
    update_all_ghosts();
    Matrix mass;
    check(MatDuplicate(moving_.mass().get(), MAT_COPY_VALUES, mass.put()), "MatDuplicate");
    StepSystem system(std::move(mass), held_, false);
    return add_solution(system, 0.0);
  }

  bool step(StepSystem& system, double h) {
    const Vector before = copy_of(state_.acceleration);
    add_to(state_.displacement, h, state_.velocity);
    add_to(state_.displacement, (0.5 - kBeta) * h * h, before);
    add_to(state_.velocity, (1.0 - kGamma) * h, before);
    check(VecZeroEntries(state_.acceleration.get()), "VecZeroEntries");
    moving_.impose(groups_, state_);
    update_all_ghosts();
    guess_ = copy_of(before);
    return add_solution(system, h);
  }

  /// Solves for the accelerations that nothing prescribes and adds them, with what they move in a step `h`.
  bool add_solution(StepSystem& system, double h) {
    const Vector missing = moving_.residual(groups_, state_);
    moving_.clear_held(groups_, missing);
    Vector found = guess_ ? copy_of(guess_) : zeros_like(missing);
    moving_.clear_held(groups_, found);
    const Stopwatch watch;
    const double residual = system.solve(missing, options_.tolerance_relative, found, found_);
    found_.solve_s += watch.seconds();
    found_.residual_relative = std::max(found_.residual_relative, residual);
    if (!(residual <= std::max(options_.tolerance_relative, kRounding))) return false;
    moving_.clear_held(groups_, found);
    add_to(state_.acceleration, 1.0, found);
    add_to(state_.velocity, kGamma * h, found);
    add_to(state_.displacement, kBeta * h * h, found);
    update_all_ghosts();
    return true;
  }

  static Vector copy_of(const Vector& v) {
    Vector made = zeros_like(v);
    check(VecCopy(v.get(), made.get()), "VecCopy");
    return made;
  }

  void update_all_ghosts() const {
    update_ghosts(state_.displacement);
    update_ghosts(state_.velocity);
    update_ghosts(state_.acceleration);
  }

  static constexpr double kRounding = 1e-11;  ///< what factors reach of a matrix near its worst

  const MovingBody& moving_;
  const NewmarkOptions& options_;
  bool direct_;
  Motion& found_;
  MotionState state_;
  Vector guess_;
  std::vector<std::size_t> groups_;
  std::vector<PetscInt> held_;
  std::uint64_t stride_ = 1;
};

}  // namespace

Motion find_motion(const TetMesh& mesh, const MotionProblem& problem, ElasticBody& body,
                   const NewmarkOptions& options) {
  if (problem.body.strain != StrainSize::kSmall)
    throw InputError("strain", 0, "small: finite elements move by linear elasticity", "large");
  const Stopwatch watch;
  const bool direct = options.solver == SolverChoice::kAuto ? body.global_nodes() <= kMostNodesForMumps
                                                            : options.solver == SolverChoice::kMumps;
  Motion found;
  found.states = MotionStates(problem.duration_s, mesh.points.size());
  found.solver = direct ? "mumps" : "conjugate gradients";
  found.history.columns = history_columns(problem);
  const MovingBody moving(mesh, problem, body, direct ? "aij" : "baij");
  found.outcome = Stepping(moving, options, direct, found).run() ? "completed" : "not_converged";
  found.assembly_s = watch.seconds() - found.solve_s;
  return found;
}

}  // namespace palpate::reference::fenicsx

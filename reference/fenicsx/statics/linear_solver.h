// The tangent of a held body, and the solution of one linear system with it.
#pragma once

#include <memory>
#include <string>

#include "reference/fenicsx/statics/boundary_terms.h"
#include "reference/fenicsx/statics/elastic_body.h"

namespace palpate::reference::fenicsx {

enum class SolverChoice {
  kAuto,   ///< by size
  kMumps,  ///< sparse direct factors
  kGamg    ///< conjugate gradients with algebraic multigrid; quadratic shapes by way of linear ones
};

/// One linear solve.
struct LinearReport {
  int iterations = 0;
  double residual_relative = 0.0;  ///< |b - A x| / |b|, computed anew
  double right_side_norm = 0.0;    ///< |b|, in N: what is out of balance, held displacements taken in
  bool converged = false;          ///< to the tolerance, or to the rounding of |A| |x|
};

/// Assembles and solves. Keeps its matrices from one solve to the next.
class TangentSystem {
 public:
  /// `body` and `terms` must outlive it.
  TangentSystem(const TetMesh& mesh, const BoundaryProblem& problem, ElasticBody& body,
                const BoundaryTerms& terms, SolverChoice choice);
  ~TangentSystem();
  TangentSystem(const TangentSystem&) = delete;
  TangentSystem& operator=(const TangentSystem&) = delete;

  /// Solves K(u) step = residual for the free entries of `step`; its held entries stay as they are given, the
  /// free ones must be zero. At small strain K is assembled and factored once: later solves take it as it is,
  /// and their held entries must be zero.
  LinearReport solve(const Vector& u, const Vector& residual, double tolerance_relative, const Vector& step);

  /// "mumps", "gamg" or "p-multigrid + gamg".
  const std::string& name() const { return name_; }
  double assembly_s() const { return assembly_s_; }
  double solve_s() const { return solve_s_; }

 private:
  /// One set of shape functions: the body's own, and for multigrid the linear ones below quadratic ones.
  struct Level {
    ElasticBody* body = nullptr;
    const BoundaryTerms* terms = nullptr;
    Matrix tangent;
    Vector displacement;
  };

  void assemble(Level& level, const Vector& u, bool definite) const;
  void hold(Level& level) const;
  LinearReport examine(const Vector& right, const Vector& step, double tolerance_relative,
                       const Vector& left_over) const;
  LinearReport solve_assembled(const Vector& right, double tolerance_relative, const Vector& step) const;
  void create_coarse_level(const TetMesh& mesh, const BoundaryProblem& problem);
  void create_solver(const TetMesh& mesh);
  void create_multigrid();
  void restrict_displacement(const Vector& u);

  Level fine_;
  Level coarse_;
  std::unique_ptr<ElasticBody> coarse_body_;
  std::unique_ptr<BoundaryTerms> coarse_terms_;
  std::vector<std::pair<std::size_t, std::size_t>> same_node_;  ///< coarse and fine node at one vertex
  Matrix interpolation_;
  NullSpace rigid_motions_;
  Solver solver_;
  bool small_ = true;
  bool is_ready_ = false;  ///< small strain: the tangent stands
  std::string name_;
  double assembly_s_ = 0.0;
  double solve_s_ = 0.0;
};

}  // namespace palpate::reference::fenicsx

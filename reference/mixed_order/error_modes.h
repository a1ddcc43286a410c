// What linear elements lack, learnt from solves of quadratic ones under loads that are drawn.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/dynamics/enriched/principal_fields.h"
#include "core/dynamics/linear_algebra/sparse_factor.h"
#include "reference/mixed_order/solid_system.h"

namespace palpate::reference {

/// How the modes are learnt.
struct TrainingOptions {
  std::size_t modes = 100;
  std::size_t samples = 200;
  std::size_t holdings = 0;  ///< 0: all loads on the scene's own supports; else on so many that are drawn
  std::uint64_t seed = 1;
  double least_radius = 1.0;  ///< of a drawn load, in mean edges of the skin; the largest is four
};

/// An organ, the finer quadratic elements that teach, and its linear functions among theirs.
struct TrainingBody {
  TetMesh organ;
  BoundaryProblem problem;       ///< on the organ's mesh
  int refine = 0;                ///< how often `fine` is refined
  SolidSpace fine;               ///< its map takes linear functions of the organ's mesh
  BoundaryProblem fine_problem;  ///< on the finer mesh
};
TrainingBody build_training_body(const TetMesh& mesh, const BoundaryProblem& problem, int refine);

/// The stiffness of a finer space on one holding, and of the linear functions in it.
struct TrainingSystem {
  dynamics::ElementMatrices body;    ///< of the finer space, without supports
  dynamics::BlockMatrix whole;       ///< with them
  dynamics::ElementMatrices coarse;  ///< T^T whole T
  std::vector<std::uint8_t> held;    ///< of the finer space's nodes
  std::vector<std::uint8_t> coarse_held;
  dynamics::NodeLoads loads;
};
/// `body` is moved through, so that it is assembled once.
TrainingSystem build_training_system(const TrainingBody& training, dynamics::ElementMatrices body,
                                     const BoundaryProblem& organ_problem);

/// A force of 1 N in a direction that is drawn, spread evenly over the faces within a radius (from
/// `least_radius` to four mean edges of the skin) of a skin vertex that is drawn. On the organ's mesh,
/// without holding.
struct LoadDraw {
  std::uint64_t seed = 1;
  double least_radius = 1.0;
};
BoundaryProblem draw_load(const TetMesh& mesh, const std::vector<Triangle>& skin, const LoadDraw& draw);

/// A support that is drawn: the skin below a plane, a tenth to three tenths of the body's extent.
BoundaryProblem draw_holding(const TetMesh& mesh, const std::vector<Triangle>& skin,
                             const BoundaryProblem& problem, std::uint64_t seed);

/// The principal fields, in the mean square over the volume, of quadratic less linear answers to loads that
/// are drawn; the scene's loads are never among them. Throws: InputError for drawn holdings where faces are
/// held hard or nothing is elastic.
dynamics::PrincipalFields learn_error_modes(const TrainingBody& training, const TrainingOptions& options,
                                            const dynamics::FactorMaker& make_factor);

/// How far models are from the quadratic elements that taught them, in the deformation at the organ's
/// vertices: root mean square over loads that are drawn anew.
struct Validation {
  double linear = 0.0;
  double enriched = 0.0;
  double enriched_worst = 0.0;
};

}  // namespace palpate::reference

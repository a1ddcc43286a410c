// Moves of boundary vertices under the guard of a GuardedBoundary.
#pragma once

#include "core/simplify/refined/stable_step.h"
#include "core/simplify/skin_guard/guarded_boundary.h"
#include "core/simplify/surface/surface_collapse.h"
#include "core/simplify/tet_operations/score_rule.h"
#include "core/simplify/tet_operations/working_mesh.h"

namespace palpate::simplify {

/// What a move of smooth_boundary has to gain in the mean over the tets around, so that it is worth its
/// proof.
inline constexpr double kWorthAProof = 0.01;
inline constexpr double kWorthAProofInHaste = 0.03;  ///< where time counts most

/// One sweep over the boundary vertices: each is moved to where the sum of gains of the tets around it is
/// larger, first towards the middle of its faces and along the gradient within the tangent plane, then with
/// half of the gradient's part along the normal, as far as the bound permits; where the volume inside the
/// boundary is a thousandth off `volume`, the input's, only towards that. No move bends the skin around by
/// more than a fiftieth more, so that what is flat stays so: without this the tets get better by crumpling
/// it. A move has to gain `worth` in the mean over the tets around, and may leave a tet a tenth worse than
/// the worst around. Vertices on feature lines stay. Counts the moves.
void smooth_boundary(WorkingMesh& mesh, GuardedBoundary& boundary, const ScoreRule& scores, double volume,
                     SurfaceReport& report, double worth = kWorthAProof);

/// The same towards the middle of the faces alone, and only where the worst tet around gets better by a
/// tenth.
void mend_boundary(WorkingMesh& mesh, GuardedBoundary& boundary, const ScoreRule& scores,
                   SurfaceReport& report);

/// Moves of vertices of a guarded skin that make a step longer: within the bound, none on a feature line, and
/// none that bends the skin around by more than a fiftieth more. Counts them.
class StepSkinMoves final : public SkinMoves {
 public:
  /// Holds references.
  StepSkinMoves(const WorkingMesh& mesh, GuardedBoundary& boundary, SurfaceReport& report)
      : mesh_(mesh), boundary_(boundary), report_(report) {}
  bool may_move(Index v) const override;
  Vec3 normal_at(Index v) const override;
  bool take_move(Index v, const Vec3& to) override;

 private:
  const WorkingMesh& mesh_;
  GuardedBoundary& boundary_;
  SurfaceReport& report_;
  BoundaryChange change_;
};

}  // namespace palpate::simplify

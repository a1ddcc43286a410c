// Moving free vertices to where the tets around them are better.
#pragma once

#include <cstdint>
#include <vector>

#include "core/simplify/cone.h"
#include "core/simplify/working_mesh.h"

namespace palpate::simplify {

/// Moves one vertex after another.
class Smoother {
 public:
  Smoother(WorkingMesh& mesh, const ScoreScale& scale) : mesh_(mesh), scale_(scale) {}

  /// Moves v to the best place found if that is better. Fills the scores of its star.
  /// Returns whether it moved.
  bool smooth(Index v, int steps);

  /// One sweep over all free vertices in storage order. Returns how many moved.
  std::uint64_t sweep(int steps);

 private:
  bool is_better(const ConeFigures& now, const ConeFigures& then) const;

  WorkingMesh& mesh_;
  const ScoreScale& scale_;
  Cone cone_;
  std::vector<double> scores_;
};

/// The base triangles of v's star, appended to `cone`.
void add_star_to_cone(const WorkingMesh& mesh, Index v, Cone& cone);

}  // namespace palpate::simplify

// The middle vertex of a block's top, which goes up and down under a guard.
#pragma once

#include "core/simplify/skin_guard/guarded_boundary.h"
#include "tests/support/small_meshes.h"

namespace palpate::testing_support {

/// A block with a guarded boundary of the given bound, and the change that moves the middle vertex of its
/// top.
struct MovedTop {
  simplify::WorkingMesh mesh;
  Index middle = kNoIndex;

  MovedTop() : mesh(simplify::build_working_mesh(make_kuhn_block(4, 4, 4), simplify::SizingField())) {
    for (Index v = 0; v < mesh.points.size(); ++v) {
      if (mesh.points[v] == Vec3{2, 2, 4}) middle = v;
    }
  }

  simplify::BoundaryChange to(const simplify::GuardedBoundary& boundary, const Vec3& place) const {
    simplify::BoundaryChange change;
    change.removed.assign(boundary.faces_of(middle).begin(), boundary.faces_of(middle).end());
    for (const Index f : change.removed) change.fresh.push_back(boundary.face(f));
    change.moved = middle;
    change.to = place;
    return change;
  }
};

}  // namespace palpate::testing_support

// The mesh struct: the one thing that the judge and the judged share.
#pragma once

#include <vector>

#include "core/base/types.h"

namespace palpate {

/// A tetrahedral mesh as plain arrays.
///
/// Shape:  points has one entry a vertex, in the mesh's own length unit; tets holds indices into points.
/// A mesh is valid when every tet is positively oriented, every face has one or two tets and every vertex
/// link is a sphere or a disc; the struct itself does not enforce that (see core/judge/mesh/judge.h).
struct TetMesh {
  std::vector<Vec3> points;
  std::vector<Tet> tets;

  friend bool operator==(const TetMesh&, const TetMesh&) = default;
};

/// A triangulated surface as plain arrays; triangles are counter-clockwise seen from outside.
struct SurfaceMesh {
  std::vector<Vec3> points;
  std::vector<Triangle> triangles;

  friend bool operator==(const SurfaceMesh&, const SurfaceMesh&) = default;
};

}  // namespace palpate

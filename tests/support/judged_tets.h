// Single tets for tests of the judge.
#pragma once

#include "core/base/random.h"
#include "core/judge/mesh/tet_shape.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::testing_support {

/// What the judge says of tet t.
inline judge::TetShape shape_of(const TetMesh& mesh, std::size_t t = 0) {
  const auto& p = mesh.points;
  const Tet& v = mesh.tets[t];
  return judge::measure_tet(p[v[0]], p[v[1]], p[v[2]], p[v[3]]);
}

inline TetMesh one_tet(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return {{a, b, c, d}, {{0, 1, 2, 3}}};
}

/// In the unit cube around the origin.
inline Vec3 random_point(SplitMix64& random) {
  return {random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
}

}  // namespace palpate::testing_support

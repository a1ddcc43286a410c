#include "reference/finite_spheres/quadrature.h"

#include <cmath>
#include <cstddef>
#include <string>

#include "core/base/error.h"
#include "core/mesh/subdivision/refinement.h"

namespace palpate::reference {
namespace {

/// Four points: near one corner each.
void add_four(double near, double weight, std::vector<TetPoint>& rule) {
  for (std::size_t i = 0; i < 4; ++i) {
    TetPoint point{{near, near, near, near}, weight};
    point.at[i] = 1.0 - 3.0 * near;
    rule.push_back(point);
  }
}

/// Six points: near one edge's middle each.
void add_six(double far, double weight, std::vector<TetPoint>& rule) {
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i + 1; j < 4; ++j) {
      TetPoint point{{far, far, far, far}, weight};
      point.at[i] = point.at[j] = 0.5 - far;
      rule.push_back(point);
    }
  }
}

std::vector<TetPoint> simple_rule(int points) {
  std::vector<TetPoint> rule;
  if (points == 1) {
    rule.push_back({{0.25, 0.25, 0.25, 0.25}, 1.0});
  } else if (points == 4) {
    add_four((5.0 - std::sqrt(5.0)) / 20.0, 0.25, rule);
  } else if (points == 14) {
    add_four(0.31088591926330060980, 0.11268792571801585080, rule);
    add_four(0.09273525031089122640, 0.07349304311636194954, rule);
    add_six(0.04550370412564964949, 0.04254602077708146644, rule);
  } else {
    throw InputError("points", 0, "1, 4 or 14", std::to_string(points));
  }
  return rule;
}

/// The four parts of a triangle, given by barycentric corners.
using Corners = std::array<std::array<double, 3>, 3>;

std::vector<Corners> split(const std::vector<Corners>& whole) {
  const auto middle = [](const std::array<double, 3>& a, const std::array<double, 3>& b) {
    return std::array<double, 3>{0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.5 * (a[2] + b[2])};
  };
  std::vector<Corners> parts;
  for (const Corners& c : whole) {
    const auto ab = middle(c[0], c[1]);
    const auto bc = middle(c[1], c[2]);
    const auto ca = middle(c[2], c[0]);
    parts.push_back({c[0], ab, ca});
    parts.push_back({ab, c[1], bc});
    parts.push_back({ca, bc, c[2]});
    parts.push_back({ab, bc, ca});
  }
  return parts;
}

}  // namespace

std::vector<TetPoint> build_tet_rule(int points, int subdivide) {
  const std::vector<TetPoint> simple = simple_rule(points);
  TetMesh parts{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}};
  for (int i = 0; i < subdivide; ++i) parts = refine_uniformly(parts);
  std::vector<TetPoint> rule;
  rule.reserve(parts.tets.size() * simple.size());
  for (const Tet& tet : parts.tets) {
    for (const TetPoint& point : simple) {
      Vec3 at;
      for (std::size_t i = 0; i < 4; ++i) at = at + point.at[i] * parts.points[tet[i]];
      rule.push_back({{1.0 - at.x - at.y - at.z, at.x, at.y, at.z},
                      point.weight / static_cast<double>(parts.tets.size())});
    }
  }
  return rule;
}

std::vector<FacePoint> build_face_rule(int subdivide) {
  std::vector<Corners> parts{{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}};
  for (int i = 0; i < subdivide; ++i) parts = split(parts);
  std::vector<FacePoint> rule;
  for (const Corners& part : parts) {
    for (FacePoint point : build_radon_rule()) {
      const std::array<double, 3> inner = point.at;
      for (std::size_t k = 0; k < 3; ++k)
        point.at[k] = inner[0] * part[0][k] + inner[1] * part[1][k] + inner[2] * part[2][k];
      point.weight /= static_cast<double>(parts.size());
      rule.push_back(point);
    }
  }
  return rule;
}

std::vector<FacePoint> build_dual_face_rule() {
  std::vector<FacePoint> rule;
  for (std::size_t corner = 0; corner < 3; ++corner) {
    for (const std::size_t other : {(corner + 1) % 3, (corner + 2) % 3}) {
      // The mean of the corner, the middle of the edge to `other` and the face's middle.
      FacePoint point{{1.0 / 9.0, 1.0 / 9.0, 1.0 / 9.0}, 1.0 / 6.0};
      point.at[corner] += 1.0 / 2.0;
      point.at[other] += 1.0 / 6.0;
      rule.push_back(point);
    }
  }
  return rule;
}

}  // namespace palpate::reference

// Integrals over triangles by sums over points.
#pragma once

#include <array>
#include <vector>

namespace palpate {

/// A point of a rule over a face, in barycentric coordinates, with its share of the area; the shares sum
/// to 1.
struct FacePoint {
  std::array<double, 3> at{};
  double weight = 0.0;
};

/// Seven points over a face, all inside and with positive weights, exact for polynomials of degree 5.
/// Source: J. Radon, Monatsh. Math. 52 (1948), 286-300.
std::vector<FacePoint> build_radon_rule();

}  // namespace palpate

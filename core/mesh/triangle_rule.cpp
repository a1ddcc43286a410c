#include "core/mesh/triangle_rule.h"

#include <cmath>
#include <cstddef>

namespace palpate {

std::vector<FacePoint> build_radon_rule() {
  std::vector<FacePoint> rule{{{1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0}, 9.0 / 40.0}};
  const double root = std::sqrt(15.0);
  for (const double sign : {1.0, -1.0}) {
    const double near = (6.0 + sign * root) / 21.0;
    for (std::size_t i = 0; i < 3; ++i) {
      FacePoint point{{near, near, near}, (155.0 + sign * root) / 1200.0};
      point.at[i] = 1.0 - 2.0 * near;
      rule.push_back(point);
    }
  }
  return rule;
}

}  // namespace palpate

#include "core/springs/identification/isotropy_rows.h"

#include <cmath>

namespace palpate::springs {

std::array<double, kIsotropyRows> isotropy_coefficients(const Vec3& direction) {
  const auto [x, y, z] = direction;
  const double xx = x * x;
  const double yy = y * y;
  const double zz = z * z;
  const double root6 = std::sqrt(6.0);
  const double root12 = std::sqrt(12.0);
  return {xx * xx,
          yy * yy,
          zz * zz,
          2.0 * xx * x * y,
          2.0 * xx * x * z,
          2.0 * yy * y * x,
          2.0 * yy * y * z,
          2.0 * zz * z * x,
          2.0 * zz * z * y,
          root6 * xx * yy,
          root6 * xx * zz,
          root6 * yy * zz,
          root12 * xx * y * z,
          root12 * yy * x * z,
          root12 * zz * x * y};
}

std::array<double, kIsotropyRows> isotropy_means() {
  const double mixed = std::sqrt(6.0) / 15.0;
  return {0.2, 0.2, 0.2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, mixed, mixed, mixed, 0.0, 0.0, 0.0};
}

std::array<double, kPatchRows> patch_coefficients(const Vec3& direction) {
  const auto [x, y, z] = direction;
  const double root3 = std::sqrt(3.0);
  return {
      x * x * x,         y * y * y,         z * z * z,         root3 * x * x * y, root3 * x * x * z,
      root3 * y * y * x, root3 * y * y * z, root3 * z * z * x, root3 * z * z * y, std::sqrt(6.0) * x * y * z};
}

std::array<double, kPatchRows> patch_target(const Vec3& area) {
  const double root3 = std::sqrt(3.0);
  return {3.0 * area.x,   3.0 * area.y,   3.0 * area.z,   root3 * area.y, root3 * area.z,
          root3 * area.x, root3 * area.z, root3 * area.x, root3 * area.y, 0.0};
}

}  // namespace palpate::springs

#include "core/mesh/orientation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace palpate {
namespace {

/// A sum of doubles that do not overlap, smallest first; exact arithmetic by error-free transformations.
template <std::size_t Capacity>
struct Expansion {
  std::array<double, Capacity> part{};
  std::size_t size = 0;
};

/// sum + error = a + b exactly (Knuth).
double two_sum(double a, double b, double& error) {
  const double sum = a + b;
  const double b_virtual = sum - a;
  error = (a - (sum - b_virtual)) + (b - b_virtual);
  return sum;
}

/// product + error = a * b exactly, by fused multiply-add.
double two_product(double a, double b, double& error) {
  const double product = a * b;
  error = std::fma(a, b, -product);
  return product;
}

/// Adds one double to an expansion (grow-expansion with zero elimination).
template <std::size_t Capacity>
void add(Expansion<Capacity>& e, double b) {
  double carry = b;
  std::size_t out = 0;
  for (std::size_t i = 0; i < e.size; ++i) {
    double error = 0.0;
    carry = two_sum(carry, e.part[i], error);
    if (error != 0.0) e.part[out++] = error;
  }
  if (carry != 0.0) e.part[out++] = carry;
  e.size = out;
}

/// Adds sign * a * b * c exactly: four partial products.
template <std::size_t Capacity>
void add_product(Expansion<Capacity>& e, double sign, double a, double b, double c) {
  double low = 0.0;
  const double high = two_product(a, b, low);
  double error = 0.0;
  double product = two_product(high, c, error);
  add(e, sign * error);
  add(e, sign * product);
  product = two_product(low, c, error);
  add(e, sign * error);
  add(e, sign * product);
}

/// Adds sign * det(p, q, r) exactly.
template <std::size_t Capacity>
void add_determinant(Expansion<Capacity>& e, double sign, const Vec3& p, const Vec3& q, const Vec3& r) {
  add_product(e, sign, p.x, q.y, r.z);
  add_product(e, sign, p.y, q.z, r.x);
  add_product(e, sign, p.z, q.x, r.y);
  add_product(e, -sign, p.x, q.z, r.y);
  add_product(e, -sign, p.y, q.x, r.z);
  add_product(e, -sign, p.z, q.y, r.x);
}

/// Scales by a power of two so that the largest coordinate is near 1: no overflow, and no rounding.
void scale_to_one(std::array<Vec3, 4>& p) {
  double largest = 0.0;
  for (const Vec3& v : p) largest = std::max({largest, std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
  if (largest == 0.0) return;
  const int shift = -std::ilogb(largest);
  for (Vec3& v : p) v = {std::scalbn(v.x, shift), std::scalbn(v.y, shift), std::scalbn(v.z, shift)};
}

}  // namespace

// The determinant |b-a, c-a, d-a| written out as four 3x3 determinants of the coordinates themselves.
int orientation_by_expansions(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  std::array<Vec3, 4> p{a, b, c, d};
  scale_to_one(p);
  Expansion<96> e;
  add_determinant(e, 1.0, p[1], p[2], p[3]);
  add_determinant(e, -1.0, p[0], p[2], p[3]);
  add_determinant(e, 1.0, p[0], p[1], p[3]);
  add_determinant(e, -1.0, p[0], p[1], p[2]);
  if (e.size == 0) return 0;
  return e.part[e.size - 1] > 0.0 ? 1 : -1;
}

}  // namespace palpate

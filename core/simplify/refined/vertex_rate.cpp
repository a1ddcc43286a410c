#include "core/simplify/refined/vertex_rate.h"

#include <algorithm>
#include <cmath>

namespace palpate::simplify {
namespace {

constexpr double kSpread = kLamePerShear + 1.0;  ///< (lambda + mu) / mu

}  // namespace

ShapeGradients gradients_of_tet(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  ShapeGradients out;
  out.six_volumes = dot(cross(a - p, b - p), c - p);
  if (out.six_volumes == 0.0) return out;
  const double inverse = 1.0 / out.six_volumes;
  auto& [at_p, at_a, at_b, at_c] = out.at_corner;
  at_a = inverse * cross(b - p, c - p);
  at_b = inverse * cross(c - p, a - p);
  at_c = inverse * cross(a - p, b - p);
  at_p = Vec3{} - at_a - at_b - at_c;
  return out;
}

void add_tet(const Vec3& p, const std::array<const Vec3*, 3>& base, const std::array<VertexRate*, 4>& to,
             double sign) {
  const ShapeGradients shape = gradients_of_tet(p, *base[0], *base[1], *base[2]);
  if (shape.six_volumes == 0.0) return;
  const double volume = std::abs(shape.six_volumes) / 6.0;
  for (std::size_t i = 0; i < 4; ++i) to[i]->add(shape.at_corner[i], volume, sign);
}

void VertexRate::add(const Vec3& gradient, double tet_volume, double sign) {
  const double w = sign * tet_volume;
  stiffness[0] += w * gradient.x * gradient.x;
  stiffness[1] += w * gradient.y * gradient.y;
  stiffness[2] += w * gradient.z * gradient.z;
  stiffness[3] += w * gradient.x * gradient.y;
  stiffness[4] += w * gradient.x * gradient.z;
  stiffness[5] += w * gradient.y * gradient.z;
  volume += w;
}

/// The largest eigenvalue of the symmetric S by the trigonometric form of Cardano's.
double VertexRate::rate() const {
  if (!(volume > 0.0)) return 0.0;
  const auto [xx, yy, zz, xy, xz, yz] = stiffness;
  const double trace = xx + yy + zz;
  const double mean = trace / 3.0;
  const double off = xy * xy + xz * xz + yz * yz;
  const double dx = xx - mean;
  const double dy = yy - mean;
  const double dz = zz - mean;
  const double p = std::sqrt((dx * dx + dy * dy + dz * dz + 2.0 * off) / 6.0);
  double largest = mean;
  if (p > 1e-12 * mean) {
    const double det = dx * (dy * dz - yz * yz) - xy * (xy * dz - yz * xz) + xz * (xy * yz - dy * xz);
    largest = mean + 2.0 * p * std::cos(std::acos(std::clamp(det / (2.0 * p * p * p), -1.0, 1.0)) / 3.0);
  }
  return (kSpread * largest + trace) / (0.25 * volume);
}

VertexRate measure_vertex(const WorkingMesh& mesh, Index v) {
  VertexRate own;
  VertexRate other;
  for (const Index t : mesh.star(v)) {
    const Triangle base = face_opposite(mesh.tets[t], corner_in(mesh.tets[t], v));
    add_tet(mesh.points[v], {&mesh.points[base[0]], &mesh.points[base[1]], &mesh.points[base[2]]},
            {&own, &other, &other, &other}, 1.0);
  }
  return own;
}

double greatest_rate(const TetMesh& mesh) {
  const WorkingMesh working = build_working_mesh(TetMesh(mesh), SizingField());
  double most = 0.0;
  for (Index v = 0; v < working.points.size(); ++v) {
    if (working.is_vertex_alive(v)) most = std::max(most, measure_vertex(working, v).rate());
  }
  return most;
}

}  // namespace palpate::simplify

#include "core/dynamics/statics/tangent_system.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/dynamics/linear_algebra/vertex_field.h"

namespace palpate::dynamics {
namespace {

std::vector<Triangle> support_faces(const Loads& loads) {
  std::vector<Triangle> faces;
  faces.reserve(loads.supports.size());
  for (const SupportFace& support : loads.supports) faces.push_back(support.face);
  return faces;
}

}  // namespace

TangentSystem::TangentSystem(const ElasticModel& model, const Loads& loads, const LinearOptions& options)
    : model_(&model),
      loads_(&loads),
      options_(options),
      matrix_(build_tangent_pattern(model, support_faces(loads))),
      solver_(options) {}

LinearStatus TangentSystem::prepare(std::span<const Vec3> displacement, TangentKind kind, double shift) {
  std::fill(matrix_.blocks.begin(), matrix_.blocks.end(), Mat3{});
  add_tangent(*model_, displacement, kind, matrix_);
  add_support_tangent(*loads_, matrix_);
  left_.clear();
  right_.clear();
  if (model_->volume_force) add_volume_part(displacement);
  if (shift > 0.0) {
    double mean = 0.0;
    for (Index v = 0; v < matrix_.rows(); ++v) {
      for (std::size_t k = matrix_.offsets[v]; k < matrix_.offsets[v + 1]; ++k) {
        if (matrix_.columns[k] == v) mean += std::abs(trace(matrix_.blocks[k])) / 3.0;
      }
    }
    mean /= static_cast<double>(matrix_.rows());
    for (Index v = 0; v < matrix_.rows(); ++v) add_block(matrix_, v, v, (shift * mean) * kIdentity);
  }
  return solver_.prepare(matrix_, loads_->held);
}

void TangentSystem::add_volume_part(std::span<const Vec3> displacement) {
  const VolumeForce& volume_force = *model_->volume_force;
  VolumeForceTangent part = differentiate_volume_force(volume_force, model_->rest, displacement);
  const std::size_t n = part.direction.size();
  bool turns = false;
  for (Index v = 0; v < n; ++v) {
    const auto& t = part.turning[v];
    turns = turns || std::any_of(t.begin(), t.end(), [](double x) { return x != 0.0; });
    add_block(matrix_, v, v, {{t[0], t[1], t[2], t[1], t[3], t[4], t[2], t[4], t[5]}});
    part.direction[v] = volume_force.stiffness_n_per_m3 * part.direction[v];
  }
  left_.push_back(std::move(part.direction));
  right_.push_back(std::move(part.volume_gradient));
  if (!turns) return;
  constexpr std::array<Vec3, 3> kAxes{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
  for (std::size_t i = 0; i < 3; ++i) {
    std::vector<Vec3> u(n);
    std::vector<Vec3> w(n);
    for (std::size_t v = 0; v < n; ++v) {
      const auto& t = part.turning[v];
      u[v] = Mat3{{t[0], t[1], t[2], t[1], t[3], t[4], t[2], t[4], t[5]}}.row(i);
      w[v] = volume_force.center_weights[v] * kAxes[i];
    }
    left_.push_back(std::move(u));
    right_.push_back(std::move(w));
  }
}

LinearResult TangentSystem::solve(std::span<const Vec3> b, double tolerance, std::span<Vec3> x) {
  solver_.set_tolerance(tolerance);
  LinearResult result = solver_.solve(b, x);
  if (left_.empty() || result.status != LinearStatus::kSolved) return result;
  const std::size_t rank = left_.size();
  std::vector<std::vector<Vec3>> y(rank, std::vector<Vec3>(x.size()));
  for (std::size_t i = 0; i < rank; ++i) {
    const LinearResult part = solver_.solve(left_[i], y[i]);
    result.iterations += part.iterations;
    if (part.status != LinearStatus::kSolved) return {part.status, result.iterations, part.residual_relative};
  }
  const auto size = static_cast<Eigen::Index>(rank);
  Eigen::MatrixXd small = Eigen::MatrixXd::Identity(size, size);
  Eigen::VectorXd rhs(size);
  for (std::size_t i = 0; i < rank; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    for (std::size_t j = 0; j < rank; ++j)
      small(row, static_cast<Eigen::Index>(j)) -= dot_of(right_[i], y[j]);
    rhs[row] = dot_of(right_[i], x);
  }
  const Eigen::VectorXd weights = small.partialPivLu().solve(rhs);
  if (!weights.allFinite()) return {LinearStatus::kIndefinite, result.iterations, 0.0};
  for (std::size_t i = 0; i < rank; ++i) add_scaled(x, weights[static_cast<Eigen::Index>(i)], y[i]);
  return result;
}

void TangentSystem::apply(std::span<const Vec3> x, std::span<Vec3> y) const {
  multiply(matrix_, x, y, options_.threads);
  for (std::size_t i = 0; i < left_.size(); ++i) {
    const double weight = dot_of(right_[i], x);
    add_scaled(y, -weight, left_[i]);
  }
}

}  // namespace palpate::dynamics

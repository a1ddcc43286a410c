#include "core/dynamics/enriched/enriched_elements.h"

#include <Eigen/Dense>
#include <utility>

#include "core/base/error.h"
#include "core/dynamics/linear_algebra/signed_index.h"
#include "core/dynamics/linear_algebra/vertex_field.h"

namespace palpate::dynamics {
namespace {

/// Share of a field's energy that has to be its own.
constexpr double kAlone = 1e-10;

}  // namespace

EnrichedElements::EnrichedElements(const HeldElements& coarse, const NodeMap& map, const BlockMatrix& fine,
                                   std::span<const std::vector<Vec3>> fields)
    : coarse_(coarse), map_(map), fine_(fine) {
  const std::vector<Vec3> nothing(map.nodes.size());
  std::vector<Vec3> image(map.rows());
  std::vector<std::vector<Vec3>> rest;
  for (const std::vector<Vec3>& field : fields) {
    require(field.size() == map.rows(), "fields with one entry a node");
    multiply(fine, field, image);
    const std::vector<Vec3> linear = coarse.rest_under(apply_transposed(map, image), nothing);
    rest.push_back(field);
    add_scaled(rest.back(), -1.0, apply_map(map, linear));
  }
  const auto n = signed_index(rest.size());
  if (n == 0) return;
  Eigen::MatrixXd energy(n, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    multiply(fine, rest[static_cast<std::size_t>(j)], image);
    for (Eigen::Index i = 0; i < n; ++i) energy(i, j) = dot_of(rest[static_cast<std::size_t>(i)], image);
  }
  const Eigen::LLT<Eigen::MatrixXd> factor(energy);
  const Eigen::MatrixXd lower = factor.matrixL();
  // What is left of a field beside those before it: nothing but rounding, if it is one of their sums.
  const auto is_alone = [&](Eigen::Index i) { return lower(i, i) * lower(i, i) > kAlone * energy(i, i); };
  bool are_alone = factor.info() == Eigen::Success;
  for (Eigen::Index i = 0; i < n && are_alone; ++i) are_alone = is_alone(i);
  if (!are_alone) throw UnavailableError("the fields beside the linear elements are not independent of them");
  // z = L^-1 rest, from the first on.
  for (Eigen::Index i = 0; i < n; ++i) {
    std::vector<Vec3>& z = rest[static_cast<std::size_t>(i)];
    for (Eigen::Index j = 0; j < i; ++j) add_scaled(z, -lower(i, j), rest[static_cast<std::size_t>(j)]);
    for (Vec3& at : z) at = (1.0 / lower(i, i)) * at;
  }
  fields_ = std::move(rest);
}

std::vector<Vec3> EnrichedElements::rest_under(std::span<const Vec3> force_n,
                                               std::span<const Vec3> held_by_m) const {
  const std::vector<Vec3> linear = coarse_.rest_under(apply_transposed(map_, force_n), held_by_m);
  std::vector<Vec3> all = apply_map(map_, linear);
  std::vector<Vec3> left(all.size());
  multiply(fine_, all, left);
  for (std::size_t i = 0; i < left.size(); ++i) left[i] = force_n[i] - left[i];
  for (const std::vector<Vec3>& z : fields_) add_scaled(all, dot_of(z, left), z);
  return all;
}

}  // namespace palpate::dynamics

#include "core/judge/displacement/chosen_points.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/judge/displacement/displacement.h"
#include "core/judge/displacement/rigid_part.h"
#include "core/judge/mesh/compensated_sum.h"

namespace palpate::judge {
namespace {

/// What is less than this share of the largest displacement of the whole body is rounding.
constexpr double kStill = 1e-12;

void check_chosen(const TetMesh& mesh, std::span<const Vec3> field, const ChosenPoints& chosen) {
  require(field.size() >= mesh.points.size(), "chosen points: fewer rows than vertices");
  require(!chosen.vertex.empty() && chosen.vertex.size() == chosen.weight.size(),
          "chosen points: none, or not a weight each");
  for (std::size_t k = 0; k < chosen.vertex.size(); ++k)
    require(chosen.vertex[k] < mesh.points.size() && chosen.weight[k] > 0.0,
            "chosen points: a vertex that does not exist, or a weight that is not above zero");
}

double weighted_size(std::span<const Vec3> field, const ChosenPoints& chosen) {
  CompensatedSum sum;
  CompensatedSum whole;
  for (std::size_t k = 0; k < chosen.vertex.size(); ++k) {
    sum.add(chosen.weight[k] * length_sq(field[chosen.vertex[k]]));
    whole.add(chosen.weight[k]);
  }
  return std::sqrt(sum.value() / whole.value());
}

}  // namespace

ChosenSize measure_chosen(const TetMesh& mesh, std::span<const Vec3> field, const ChosenPoints& chosen) {
  check_chosen(mesh, field, chosen);
  const std::size_t vertices = mesh.points.size();
  const std::vector<Vec3> rest =
      without_rigid_motion(mesh.points, volume_shares(mesh, vertices), field.first(vertices));
  ChosenSize size;
  size.l2 = weighted_size(field, chosen);
  size.deformation = weighted_size(rest, chosen);
  for (const std::size_t vertex : chosen.vertex) size.max = std::max(size.max, length(field[vertex]));
  return size;
}

ChosenError compare_chosen(const TetMesh& mesh, std::span<const Vec3> field, std::span<const Vec3> truth,
                           const ChosenPoints& chosen) {
  require(field.size() == truth.size(), "compare_chosen: fields of different sizes");
  require_finite(field, "displacement");
  require_finite(truth, "reference displacement");
  std::vector<Vec3> difference(field.size());
  double largest = 0.0;
  for (std::size_t i = 0; i < field.size(); ++i) {
    difference[i] = field[i] - truth[i];
    largest = std::max(largest, length(truth[i]));
  }
  const ChosenSize off = measure_chosen(mesh, difference, chosen);
  const ChosenSize whole = measure_chosen(mesh, truth, chosen);
  if (!(whole.max > kStill * largest))
    throw InputError("reference displacement", 0, "movement where its error is asked for", "none there");
  if (!(whole.deformation > kStill * largest))
    throw InputError("reference displacement", 0, "deformation where its error is asked for",
                     "a rigid motion there");
  return {off.l2 / whole.l2, off.deformation / whole.deformation, off.max / whole.max};
}

}  // namespace palpate::judge

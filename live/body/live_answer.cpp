#include "live/body/live_answer.h"

#include <utility>

#include "core/base/component.h"
#include "core/mesh/geometry.h"

namespace palpate::live {
namespace {

/// The integral of stiffness x (by - u) over a pad, u straight over each face.
///
/// Shape:  row[v] is where vertex v stands in `skin_m`.
Vec3 force_of(const ElasticSupport& pad, const std::vector<Vec3>& points, const std::vector<Index>& row,
              const std::vector<Vec3>& skin_m) {
  Vec3 sum;
  for (std::size_t f = 0; f < pad.patch.faces.size(); ++f) {
    const auto [a, b, c] = pad.patch.faces[f];
    const double area = 0.5 * length(cross(points[b] - points[a], points[c] - points[a]));
    const Vec3 mean = (1.0 / 3.0) * (skin_m[row[a]] + skin_m[row[b]] + skin_m[row[c]]);
    sum = sum + (pad.stiffness_pa_per_m * pad.patch.weight[f] * area) * (pad.by_m - mean);
  }
  return sum;
}

}  // namespace

LiveAnswer::LiveAnswer(TetMesh mesh, dynamics::ComplianceTable table, BoundaryProblem holding)
    : mesh_(std::move(mesh)), table_(std::move(table)), holding_(std::move(holding)) {
  holding_.strain = StrainSize::kSmall;
  const dynamics::HeldBody body(table_, mesh_, holding_);  // refuses what it cannot take
}

void LiveAnswer::press(const FacePatch& patch, double stiffness_pa_per_m) {
  BoundaryProblem problem = holding_;
  problem.supports.push_back({patch, stiffness_pa_per_m, {}});
  const dynamics::HeldBody body(table_, mesh_, problem);
  std::vector<Index> row(mesh_.points.size(), 0);
  for (std::size_t k = 0; k < vertices().size(); ++k) row[vertices()[k]] = static_cast<Index>(k);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    ElasticSupport& pad = problem.supports.back();
    pad.by_m = {};
    component(pad.by_m, axis) = 1.0;
    const auto load = body.prepare(problem);
    body.react(*load);
    body.move_skin(*load);
    std::vector<Vec3>& unit = unit_[axis];
    unit.resize(vertices().size());
    for (std::size_t k = 0; k < unit.size(); ++k) {
      const double* u = load->displacement_m.data() + 3 * k;
      unit[k] = {u[0], u[1], u[2]};
    }
    unit_force_n_[axis] = force_of(pad, mesh_.points, row, unit);
  }
  is_pressed_ = true;
}

void LiveAnswer::release() {
  is_pressed_ = false;
}

std::vector<Vec3> LiveAnswer::displacement(const Vec3& by_m) const {
  std::vector<Vec3> out(vertices().size());
  if (!is_pressed_) return out;
  for (std::size_t k = 0; k < out.size(); ++k)
    out[k] = by_m.x * unit_[0][k] + by_m.y * unit_[1][k] + by_m.z * unit_[2][k];
  return out;
}

Vec3 LiveAnswer::pad_force(const Vec3& by_m) const {
  if (!is_pressed_) return {};
  return by_m.x * unit_force_n_[0] + by_m.y * unit_force_n_[1] + by_m.z * unit_force_n_[2];
}

}  // namespace palpate::live

#include <algorithm>
#include <array>
#include <cmath>

#include "core/mesh/geometry.h"
#include "experiments/scene_problem.h"
#include "experiments/terminal.h"

namespace palpate::experiments {
namespace {

using Vec6 = std::array<double, 6>;
using Matrix6 = std::array<Vec6, 6>;

/// What resists the six rigid motions: sum of area x (N^T N) over what is held, N the rows of the motion
/// u = t + w x (p - centre) / size at a point p, t and w its six coordinates.
class Resistance {
 public:
  Resistance(const Vec3& center, double size) : center_(center), size_(size) {}

  void add_face(const TetMesh& mesh, const Triangle& face, double weight, const std::array<bool, 3>& axes) {
    const Vec3& a = mesh.points[face[0]];
    const double area = 0.5 * length(cross(mesh.points[face[1]] - a, mesh.points[face[2]] - a));
    for (const Index vertex : face) add_point(mesh.points[vertex], weight * area, axes);
  }

  const Matrix6& matrix() const { return matrix_; }

 private:
  void add_point(const Vec3& point, double weight, const std::array<bool, 3>& axes) {
    const Vec3 r = (1.0 / size_) * (point - center_);
    const std::array<Vec6, 3> rows{
        {{1, 0, 0, 0, r.z, -r.y}, {0, 1, 0, -r.z, 0, r.x}, {0, 0, 1, r.y, -r.x, 0}}};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!axes[axis]) continue;
      for (std::size_t i = 0; i < 6; ++i) {
        for (std::size_t j = 0; j < 6; ++j) matrix_[i][j] += weight * rows[axis][i] * rows[axis][j];
      }
    }
  }

  Vec3 center_;
  double size_;
  Matrix6 matrix_{};
};

/// Turns rows and columns p and q of `a` so that a[p][q] becomes 0, and collects the turns in `vectors`.
void rotate(Matrix6& a, Matrix6& vectors, std::size_t p, std::size_t q) {
  const double theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
  const double t = (theta >= 0.0 ? 1.0 : -1.0) / (std::fabs(theta) + std::sqrt(theta * theta + 1.0));
  const double c = 1.0 / std::sqrt(t * t + 1.0);
  const double s = t * c;
  for (std::size_t k = 0; k < 6; ++k) {
    const double x = a[k][p];
    a[k][p] = c * x - s * a[k][q];
    a[k][q] = s * x + c * a[k][q];
  }
  for (std::size_t k = 0; k < 6; ++k) {
    const double x = a[p][k];
    a[p][k] = c * x - s * a[q][k];
    a[q][k] = s * x + c * a[q][k];
    const double v = vectors[k][p];
    vectors[k][p] = c * v - s * vectors[k][q];
    vectors[k][q] = s * v + c * vectors[k][q];
  }
}

/// Eigenvalues on the diagonal of `a`, eigenvectors in the columns of what comes back, by Jacobi's rotations.
Matrix6 diagonalize(Matrix6& a) {
  constexpr int kMostSweeps = 60;
  Matrix6 vectors{};
  double scale = 0.0;
  for (std::size_t i = 0; i < 6; ++i) {
    vectors[i][i] = 1.0;
    scale = std::max(scale, std::fabs(a[i][i]));
  }
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    bool turned = false;
    for (std::size_t p = 0; p < 6; ++p) {
      for (std::size_t q = p + 1; q < 6; ++q) {
        if (std::fabs(a[p][q]) <= 1e-15 * scale) continue;
        rotate(a, vectors, p, q);
        turned = true;
      }
    }
    if (!turned) break;
  }
  return vectors;
}

std::string vector_text(const Vec3& v) {
  const auto number = [](double x) { return short_number(std::round(x * 1e4) / 1e4 + 0.0); };
  return "(" + number(v.x) + ", " + number(v.y) + ", " + number(v.z) + ")";
}

std::string motion_text(const Vec6& motion, const Vec3& center, double size) {
  const Vec3 t{motion[0], motion[1], motion[2]};
  const Vec3 w{motion[3], motion[4], motion[5]};
  const double turning = length(w);
  if (turning < 1e-6) return "translation along " + vector_text((1.0 / length(t)) * t);
  const Vec3 axis = (1.0 / turning) * w;
  const Vec3 through = center + (size / turning) * cross(axis, t);
  return "rotation about " + vector_text(axis) + " through " + vector_text(through) + " m";
}

}  // namespace

std::vector<std::string> find_free_motions(const BoundaryProblem& problem, const TetMesh& mesh) {
  constexpr double kFree =
      1e-10;  // of the stiffest motion; a patch of 1/1000 of the body's length is at 1e-6
  const BoundingBox box = bounding_box(mesh.points);
  const Vec3 center = 0.5 * (box.low + box.high);
  const double size = 0.5 * length(box.high - box.low);
  Resistance resistance(center, size);
  for (const HeldFaces& held : problem.held) {
    for (const Triangle& face : held.faces) resistance.add_face(mesh, face, 1.0, held.axes);
  }
  for (const ElasticSupport& support : problem.supports) {
    for (std::size_t i = 0; i < support.patch.faces.size(); ++i)
      resistance.add_face(mesh, support.patch.faces[i], support.patch.weight[i], {true, true, true});
  }
  Matrix6 values = resistance.matrix();
  const Matrix6 vectors = diagonalize(values);
  double stiffest = 0.0;
  for (std::size_t i = 0; i < 6; ++i) stiffest = std::max(stiffest, values[i][i]);
  std::vector<std::string> free;
  for (std::size_t i = 0; i < 6; ++i) {
    if (stiffest > 0.0 && values[i][i] > kFree * stiffest) continue;
    Vec6 motion{};
    for (std::size_t k = 0; k < 6; ++k) motion[k] = vectors[k][i];
    free.push_back(motion_text(motion, center, size));
  }
  return free;
}

}  // namespace palpate::experiments

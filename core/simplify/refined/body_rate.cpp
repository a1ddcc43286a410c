#include "core/simplify/refined/body_rate.h"

#include <Spectra/SymEigsSolver.h>
#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <vector>

#include "core/simplify/refined/vertex_rate.h"

namespace palpate::simplify {
namespace {

constexpr Eigen::Index kVectors = 20;  ///< that Lanczos's method keeps
constexpr double kTolerance = 1e-3;

/// M^-1/2 K M^-1/2 / mu, tet by tet, as Spectra asks for it.
class ScaledStiffness {
 public:
  using Scalar = double;  // NOLINT(readability-identifier-naming): Spectra's name

  explicit ScaledStiffness(const TetMesh& mesh) : inverse_root_(mesh.points.size(), 0.0) {
    parts_.reserve(mesh.tets.size());
    for (const Tet& t : mesh.tets) {
      const std::vector<Vec3>& p = mesh.points;
      const ShapeGradients shape = gradients_of_tet(p[t[0]], p[t[1]], p[t[2]], p[t[3]]);
      const double volume = shape.six_volumes / 6.0;
      for (const Index v : t) inverse_root_[v] += 0.25 * volume;
      parts_.push_back({t, volume, shape.at_corner});
    }
    for (double& mass : inverse_root_) mass = mass > 0.0 ? 1.0 / std::sqrt(mass) : 0.0;
  }

  Eigen::Index rows() const { return static_cast<Eigen::Index>(3 * inverse_root_.size()); }
  Eigen::Index cols() const { return rows(); }

  void perform_op(const double* x, double* y) const {
    std::fill(y, y + rows(), 0.0);
    for (const Part& part : parts_) {
      std::array<Vec3, 3> slope{};  // of each component
      for (std::size_t i = 0; i < 4; ++i) {
        const double* u = x + 3 * std::size_t{part.corners[i]};
        const double root = inverse_root_[part.corners[i]];
        for (std::size_t k = 0; k < 3; ++k) slope[k] = slope[k] + (root * u[k]) * part.gradients[i];
      }
      const double spread = kLamePerShear * (slope[0].x + slope[1].y + slope[2].z);
      const double xy = slope[0].y + slope[1].x;
      const double xz = slope[0].z + slope[2].x;
      const double yz = slope[1].z + slope[2].y;
      const std::array<Vec3, 3> stress{Vec3{2.0 * slope[0].x + spread, xy, xz},
                                       Vec3{xy, 2.0 * slope[1].y + spread, yz},
                                       Vec3{xz, yz, 2.0 * slope[2].z + spread}};
      for (std::size_t i = 0; i < 4; ++i) {
        double* f = y + 3 * std::size_t{part.corners[i]};
        const double weight = part.volume * inverse_root_[part.corners[i]];
        for (std::size_t k = 0; k < 3; ++k) f[k] += weight * dot(stress[k], part.gradients[i]);
      }
    }
  }

 private:
  struct Part {
    Tet corners;
    double volume;
    std::array<Vec3, 4> gradients;  ///< of the corners' shape functions
  };
  std::vector<Part> parts_;
  std::vector<double> inverse_root_;  ///< of the masses
};

}  // namespace

std::optional<double> greatest_rate_of_body(const TetMesh& mesh, int most_restarts) {
  if (mesh.tets.empty()) return 0.0;
  ScaledStiffness stiffness(mesh);
  Spectra::SymEigsSolver<ScaledStiffness> solver(stiffness, 1, std::min(kVectors, stiffness.rows()));
  try {
    solver.init();
    solver.compute(Spectra::SortRule::LargestAlge, most_restarts, kTolerance);
  } catch (const std::runtime_error&) {  // its small tridiagonal problem can fail
    return std::nullopt;
  }
  if (solver.info() != Spectra::CompInfo::Successful) return std::nullopt;
  return solver.eigenvalues()[0];
}

bool swings_slower(const TetMesh& a, const TetMesh& b) {
  const std::optional<double> rate_a = greatest_rate_of_body(a);
  const std::optional<double> rate_b = greatest_rate_of_body(b);
  if (rate_a && rate_b) return *rate_a < *rate_b;
  return greatest_rate(a) < greatest_rate(b);
}

}  // namespace palpate::simplify

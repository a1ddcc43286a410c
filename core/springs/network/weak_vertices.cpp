#include "core/springs/network/weak_vertices.h"

#include <Eigen/Eigenvalues>
#include <span>

#include "core/base/error.h"
#include "core/springs/network/network.h"

namespace palpate::springs {
namespace {

/// The least eigenvalue of the mean of e e^T is the mean square of the sine of the angle between the
/// directions and the plane that fits them best.
bool is_flat_fan(std::span<const Index> springs, const std::vector<Vec3>& directions) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const Index s : springs) {
    const Eigen::Vector3d e(directions[s].x, directions[s].y, directions[s].z);
    sum += e * e.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(sum, Eigen::EigenvaluesOnly);
  return eigen.eigenvalues()[0] < kFlatFan * kFlatFan * static_cast<double>(springs.size());
}

}  // namespace

std::vector<Index> find_degenerate_vertices(const TetMesh& mesh, const SpringNetwork& network) {
  std::vector<Index> tets(mesh.points.size(), 0);
  for (const Tet& tet : mesh.tets) {
    for (const Index v : tet) ++tets[v];
  }
  const VertexSprings springs = build_vertex_springs(network, mesh.points.size());
  const std::vector<Vec3> directions = build_spring_directions(mesh, network);
  std::vector<Index> found;
  for (Index v = 0; v < mesh.points.size(); ++v) {
    if (tets[v] == 1 || is_flat_fan(springs.of(v), directions)) found.push_back(v);
  }
  return found;
}

std::vector<Index> find_hanging_vertices(const TetMesh& mesh, const SpringNetwork& network,
                                         double young_modulus_pa) {
  require(young_modulus_pa > 0.0, "find_hanging_vertices: the modulus must be positive");
  const std::vector<double> volumes = build_influence_volumes(mesh);
  const VertexSprings springs = build_vertex_springs(network, mesh.points.size());
  const std::vector<Vec3> directions = build_spring_directions(mesh, network);
  std::vector<Index> found;
  for (Index v = 0; v < mesh.points.size(); ++v) {
    Eigen::Matrix3d stiffness = Eigen::Matrix3d::Zero();
    double length_sq_sum = 0.0;
    for (const Index s : springs.of(v)) {
      const Eigen::Vector3d e(directions[s].x, directions[s].y, directions[s].z);
      stiffness += network.stiffness_n_per_m[s] * e * e.transpose();
      length_sq_sum += network.rest_length_m[s] * network.rest_length_m[s];
    }
    const double mean_length_sq = length_sq_sum / static_cast<double>(springs.of(v).size());
    const double usual = 4.0 * young_modulus_pa * volumes[v] / mean_length_sq;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(stiffness, Eigen::EigenvaluesOnly);
    if (!(eigen.eigenvalues()[0] >= kHanging * usual)) found.push_back(v);
  }
  return found;
}

}  // namespace palpate::springs

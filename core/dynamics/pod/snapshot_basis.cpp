#include "core/dynamics/pod/snapshot_basis.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/error.h"

namespace palpate::dynamics {
namespace {

Eigen::VectorXd flatten(std::span<const Vec3> u) {
  Eigen::VectorXd out(3 * static_cast<Eigen::Index>(u.size()));
  for (std::size_t v = 0; v < u.size(); ++v)
    out.segment<3>(3 * static_cast<Eigen::Index>(v)) << u[v].x, u[v].y, u[v].z;
  return out;
}

}  // namespace

SnapshotBasis find_snapshot_basis(std::span<const std::vector<Vec3>> snapshots, std::size_t most,
                                  double tolerance) {
  if (snapshots.empty()) throw InputError("snapshots", 0, "at least one", "none");
  const auto rows = 3 * static_cast<Eigen::Index>(snapshots.front().size());
  Eigen::MatrixXd all(rows, static_cast<Eigen::Index>(snapshots.size()));
  for (std::size_t s = 0; s < snapshots.size(); ++s) {
    if (snapshots[s].size() != snapshots.front().size())
      throw InputError("snapshots", 0, "displacements of one body", "unlike lengths");
    all.col(static_cast<Eigen::Index>(s)) = flatten(snapshots[s]);
  }
  // One-sided rotations: some times as long as divide and conquer, seconds at a few hundred snapshots, of
  // which each took a solve.
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(all, Eigen::ComputeThinU);
  const Eigen::VectorXd& values = svd.singularValues();
  if (!(values.allFinite() && values[0] > 0.0))
    throw InputError("snapshots", 0, "displacements that are finite and not all zero", "others");
  SnapshotBasis out;
  out.singular_values.assign(values.begin(), values.end());
  constexpr double kRounding = 1e-12;
  Eigen::Index count = 0;
  while (count < values.size() && static_cast<std::size_t>(count) < most &&
         values.tail(values.size() - count).norm() > tolerance * values.norm() &&
         values[count] > kRounding * values[0])
    ++count;
  out.shapes = svd.matrixU().leftCols(std::max<Eigen::Index>(count, 1));
  return out;
}

double left_out_of(const SnapshotBasis& basis, std::span<const Vec3> u) {
  const Eigen::VectorXd all = flatten(u);
  const double size = all.norm();
  return size > 0.0 ? (all - basis.shapes * (basis.shapes.transpose() * all)).norm() / size : 0.0;
}

void require_basis(const SnapshotBasis& basis, std::span<const std::uint8_t> held, const std::string& where) {
  const auto refuse = [&](const char* expected, const std::string& found) {
    throw InputError(where, 0, expected, found);
  };
  const Eigen::MatrixXd& shapes = basis.shapes;
  if (shapes.rows() != 3 * static_cast<Eigen::Index>(held.size()) || shapes.cols() == 0)
    refuse("three rows a vertex of the body", std::to_string(shapes.rows()));
  constexpr double kMost = 1e-8;
  const double off = (shapes.transpose() * shapes - Eigen::MatrixXd::Identity(shapes.cols(), shapes.cols()))
                         .cwiseAbs()
                         .maxCoeff();
  if (!(off < kMost)) refuse("orthonormal shapes", "products that are off by " + std::to_string(off));
  for (std::size_t v = 0; v < held.size(); ++v) {
    for (unsigned axis = 0; axis < 3; ++axis) {
      if (((static_cast<unsigned>(held[v]) >> axis) & 1U) == 0) continue;
      if (shapes.row(static_cast<Eigen::Index>(3 * v + axis)).cwiseAbs().maxCoeff() > kMost)
        refuse("shapes that leave held vertices where they are",
               "one that moves vertex " + std::to_string(v));
    }
  }
}

Eigen::VectorXd coordinates_of(const SnapshotBasis& basis, std::span<const Vec3> u) {
  return basis.shapes.transpose() * flatten(u);
}

std::vector<Vec3> displacement_of(const SnapshotBasis& basis, const Eigen::VectorXd& q) {
  const Eigen::VectorXd all = basis.shapes * q;
  std::vector<Vec3> out(static_cast<std::size_t>(all.size() / 3));
  for (std::size_t v = 0; v < out.size(); ++v) {
    const auto at = 3 * static_cast<Eigen::Index>(v);
    out[v] = {all[at], all[at + 1], all[at + 2]};
  }
  return out;
}

}  // namespace palpate::dynamics

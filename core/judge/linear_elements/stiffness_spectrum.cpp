#include "core/judge/linear_elements/stiffness_spectrum.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/base/random.h"

namespace palpate::judge {
namespace {

using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using View = Eigen::Map<Rows>;

/// Fields of the subspace after its first step. The fewer the cheaper, but the slowest bends of a round body
/// come in groups: where six do not converge, all fields of the start do.
constexpr std::size_t kKept = 6;
constexpr double kInverseAccuracy = 1e-5;
constexpr std::size_t kMostInverseSteps = 4000;

View view(FieldBlock& block) {
  return {block.values.data(), static_cast<Eigen::Index>(block.rows()),
          static_cast<Eigen::Index>(block.width)};
}

/// Three translations and three rotations about the origin.
FieldBlock rigid_motions(std::span<const Vec3> points) {
  FieldBlock block(points.size(), 6);
  for (std::size_t v = 0; v < points.size(); ++v) {
    const Vec3& p = points[v];
    const std::array<Vec3, 6> motion{
        {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -p.z, p.y}, {p.z, 0, -p.x}, {-p.y, p.x, 0}}};
    for (std::size_t j = 0; j < 6; ++j) {
      block.row(3 * v)[j] = motion[j].x;
      block.row(3 * v + 1)[j] = motion[j].y;
      block.row(3 * v + 2)[j] = motion[j].z;
    }
  }
  return block;
}

struct Found {
  std::optional<double> value;
  bool is_hopeless = false;  ///< more fields would not help: rounding, or nothing but rigid motions
};

/// Subspace iteration for the pencil (K, B) beside its rigid motions.
class LeastOf {
 public:
  LeastOf(const BlockRows& stiffness, std::span<const Block> blocks, std::span<const Vec3> points)
      : stiffness_(stiffness), blocks_(blocks), rigid_(rigid_motions(points)), weighted_(points.size(), 6) {
    apply_blocks(blocks_, rigid_, weighted_);
    gram_.compute(view(rigid_).transpose() * view(weighted_));
  }

  /// Takes the rigid motions off, in the inner product of B.
  void project(FieldBlock& x) {
    const Rows part = gram_.solve(view(weighted_).transpose() * view(x));
    view(x) -= view(rigid_) * part;
  }

  /// Turns the fields into the best approximations of eigenvectors in their span, B-orthonormal, least first,
  /// and keeps the first `most`; returns their values, none where nothing but rigid motions is left.
  Eigen::VectorXd rotate(FieldBlock& x, std::size_t most) {
    FieldBlock product(stiffness_.size(), x.width);
    multiply(stiffness_, x, product);
    const Rows energy = view(x).transpose() * view(product);
    apply_blocks(blocks_, x, product);
    const Rows mass = view(x).transpose() * view(product);
    const Eigen::SelfAdjointEigenSolver<Rows> span(mass);  // fields that depend on others are left out
    const double floor = 1e-10 * span.eigenvalues().maxCoeff();
    const Eigen::Index dropped = (span.eigenvalues().array() <= floor).count();
    const Eigen::Index rank = span.eigenvalues().size() - dropped;
    if (rank == 0) return {};
    const Rows basis = span.eigenvectors().rightCols(rank) *
                       span.eigenvalues().tail(rank).cwiseSqrt().cwiseInverse().asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Rows> ritz(Rows(basis.transpose() * energy * basis));
    const Eigen::Index kept = std::min(rank, static_cast<Eigen::Index>(most));
    FieldBlock turned(stiffness_.size(), static_cast<std::size_t>(kept));
    view(turned) = view(x) * (basis * ritz.eigenvectors().leftCols(kept));
    x = std::move(turned);
    return ritz.eigenvalues().head(kept);
  }

  /// The fields whose stiffness forces are B x, from x over its values. False if that did not converge.
  bool invert(FieldBlock& x, const Eigen::VectorXd& values, std::span<const Block> inverse_diagonal) {
    FieldBlock force(stiffness_.size(), x.width);
    apply_blocks(blocks_, x, force);
    view(x) = view(x) * values.cwiseInverse().asDiagonal();
    return solve_fields(stiffness_, inverse_diagonal, force, x, kInverseAccuracy, kMostInverseSteps);
  }

  /// The least eigenvalue by a subspace of at most `most` fields.
  Found find(FieldBlock x, std::size_t most, std::span<const Block> inverse_diagonal) {
    constexpr int kRounds = 40;
    constexpr double kChange = 1e-5;
    constexpr Found kHopeless{std::nullopt, true};
    project(x);
    Eigen::VectorXd values = rotate(x, most);
    if (values.size() == 0) return kHopeless;
    for (int round = 0; round < kRounds; ++round) {
      if (!invert(x, values, inverse_diagonal)) return kHopeless;
      project(x);
      const Eigen::VectorXd next = rotate(x, most);
      if (next.size() == 0 || !(next[0] > 0.0)) return kHopeless;
      const bool is_done = std::fabs(values[0] - next[0]) <= kChange * next[0];
      values = next;
      if (is_done && round > 0) return {values[0], false};
    }
    return {};
  }

 private:
  const BlockRows& stiffness_;
  std::span<const Block> blocks_;
  FieldBlock rigid_;
  FieldBlock weighted_;
  Eigen::LLT<Rows> gram_;
};

}  // namespace

double greatest_eigenvalue(const BlockRows& stiffness, std::span<const Block> blocks) {
  constexpr std::size_t kCheck = 10;
  constexpr std::size_t kMost = 400;
  const std::size_t n = stiffness.size();
  const std::vector<Block> inverse = invert_blocks(blocks);
  FieldBlock now(n, 1);
  SplitMix64 random(1);
  for (double& value : now.values) value = random.uniform() - 0.5;
  FieldBlock weighted(n, 1);
  FieldBlock product(n, 1);
  FieldBlock before(n, 1);
  std::vector<double> diagonal;
  std::vector<double> beside;
  double greatest = 0.0;
  apply_blocks(blocks, now, weighted);
  double size = std::sqrt(dots(now, weighted)[0]);
  while (diagonal.size() < std::min(kMost, 3 * n) && size > 0.0) {
    for (double& value : now.values) value /= size;
    multiply(stiffness, now, weighted);
    diagonal.push_back(dots(now, weighted)[0]);
    apply_blocks(inverse, weighted, product);
    for (std::size_t i = 0; i < product.values.size(); ++i) {
      product.values[i] -=
          diagonal.back() * now.values[i] + (beside.empty() ? 0.0 : beside.back() * before.values[i]);
    }
    before = now;
    now = product;
    apply_blocks(blocks, now, weighted);
    size = std::sqrt(dots(now, weighted)[0]);
    if (diagonal.size() % kCheck == 0 || diagonal.size() == std::min(kMost, 3 * n) || !(size > 0.0)) {
      Eigen::SelfAdjointEigenSolver<Rows> solver;
      const auto count = static_cast<Eigen::Index>(diagonal.size());
      solver.computeFromTridiagonal(Eigen::Map<const Eigen::VectorXd>(diagonal.data(), count),
                                    Eigen::Map<const Eigen::VectorXd>(beside.data(), count - 1),
                                    Eigen::EigenvaluesOnly);
      const double found = solver.eigenvalues().maxCoeff();
      if (found - greatest <= 1e-6 * found) return found;
      greatest = found;
    }
    beside.push_back(size);
  }
  return greatest;
}

std::optional<double> least_elastic_eigenvalue(const BlockRows& stiffness,
                                               std::span<const Block> inverse_diagonal,
                                               std::span<const Block> blocks, std::span<const Vec3> points,
                                               const FieldBlock& start) {
  LeastOf least(stiffness, blocks, points);
  for (const std::size_t kept : {kKept, start.width}) {
    const Found found = least.find(start, kept, inverse_diagonal);
    if (found.value || found.is_hopeless) return found.value;
  }
  return std::nullopt;
}

}  // namespace palpate::judge

#include "core/dynamics/stability/lowest_modes.h"

#include <Spectra/SymEigsShiftSolver.h>
#include <Eigen/SparseCholesky>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>
#include <stdexcept>
#include <string>

#include "core/base/error.h"
#include "core/dynamics/motion/motion_forces.h"

namespace palpate::dynamics {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

/// M^-1/2 K M^-1/2 of the free components, and which ones these are.
struct FreeBody {
  Sparse stiffness;
  std::vector<Eigen::Index> place;  ///< of component 3 v + axis among the free ones, or -1
  double largest_row = 0.0;         ///< the largest sum of absolute values of a row
};

BlockMatrix build_stiffness(const MotionModel& model) {
  BlockMatrix matrix = build_motion_pattern(model);
  add_motion_stiffness(model, std::vector<Vec3>(model.elastic.rest.size()), TangentKind::kExact, matrix);
  return matrix;
}

FreeBody build_free_body(const BlockMatrix& matrix, std::span<const double> mass_kg,
                         std::span<const std::uint8_t> held) {
  FreeBody body;
  Eigen::Index count = 0;
  for (std::size_t v = 0; v < matrix.rows(); ++v) {
    for (unsigned axis = 0; axis < 3; ++axis)
      body.place.push_back(((static_cast<unsigned>(held[v]) >> axis) & 1U) != 0 ? -1 : count++);
  }
  std::vector<Eigen::Triplet<double>> entries;
  std::vector<double> row_sum(static_cast<std::size_t>(count), 0.0);
  for (std::size_t v = 0; v < matrix.rows(); ++v) {
    for (std::size_t k = matrix.offsets[v]; k < matrix.offsets[v + 1]; ++k) {
      const std::size_t w = matrix.columns[k];
      const double scale = 1.0 / std::sqrt(mass_kg[v] * mass_kg[w]);
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) {
          const Eigen::Index row = body.place[3 * v + i];
          const Eigen::Index column = body.place[3 * w + j];
          if (row < 0 || column < 0) continue;
          const double value = scale * matrix.blocks[k](i, j);
          entries.emplace_back(row, column, value);
          row_sum[static_cast<std::size_t>(row)] += std::fabs(value);
        }
      }
    }
  }
  body.stiffness.resize(count, count);
  body.stiffness.setFromTriplets(entries.begin(), entries.end());
  for (const double sum : row_sum) body.largest_row = std::max(body.largest_row, sum);
  return body;
}

/// (K - s)^-1 as Spectra asks for it.
class ShiftedInverse {
 public:
  using Scalar = double;  // NOLINT(readability-identifier-naming): Spectra's name

  explicit ShiftedInverse(const Sparse& matrix) : matrix_(&matrix) {}

  Eigen::Index rows() const { return matrix_->rows(); }
  Eigen::Index cols() const { return matrix_->cols(); }

  void set_shift(const double& shift) {
    factor_.setShift(-shift);
    factor_.compute(*matrix_);
    is_good = factor_.info() == Eigen::Success;
  }

  void perform_op(const double* x, double* y) const {
    const Eigen::Map<const Eigen::VectorXd> in(x, rows());
    Eigen::Map<Eigen::VectorXd>(y, rows()) = factor_.solve(in);
  }

  bool is_good = false;

 private:
  const Sparse* matrix_;
  Eigen::SimplicialLDLT<Sparse> factor_;
};

}  // namespace

NaturalModes find_lowest_modes(const MotionModel& model, std::size_t count) {
  validate(model);
  return find_lowest_modes(build_stiffness(model), model.mass_kg, MotionForces(model, 1).held_bits(), count);
}

NaturalModes find_lowest_modes(const BlockMatrix& stiffness, std::span<const double> mass_kg,
                               std::span<const std::uint8_t> held, std::size_t count) {
  require(stiffness.rows() == mass_kg.size() && held.size() == mass_kg.size(), "one mass a row");
  const FreeBody body = build_free_body(stiffness, mass_kg, held);
  const Eigen::Index rows = body.stiffness.rows();
  if (count == 0 || static_cast<Eigen::Index>(count) >= rows)
    throw InputError("frequencies", 0, "from 1 to " + std::to_string(std::max<Eigen::Index>(rows, 1) - 1),
                     std::to_string(count));
  constexpr double kShift = 1e-8;  // far below the first elastic mode of meshes of up to millions of vertices
  constexpr Eigen::Index kRestarts = 1000;
  constexpr double kTolerance = 1e-10;
  const double shift = body.largest_row > 0.0 ? -kShift * body.largest_row : -1.0;
  const auto wanted = static_cast<Eigen::Index>(count);
  ShiftedInverse inverse(body.stiffness);
  Spectra::SymEigsShiftSolver<ShiftedInverse> solver(inverse, wanted, std::min(2 * wanted + 20, rows), shift);
  NaturalModes out;
  if (!inverse.is_good) return out;
  try {
    solver.init();
    solver.compute(Spectra::SortRule::LargestMagn, kRestarts, kTolerance, Spectra::SortRule::SmallestAlge);
  } catch (const std::runtime_error&) {  // its small tridiagonal problem can fail: then there is no answer
    return out;
  }
  out.converged = solver.info() == Spectra::CompInfo::Successful;
  if (!out.converged) return out;
  const Eigen::VectorXd values = solver.eigenvalues();
  const Eigen::MatrixXd vectors = solver.eigenvectors();
  std::vector<Eigen::Index> order(count);
  for (std::size_t k = 0; k < count; ++k) order[k] = static_cast<Eigen::Index>(k);
  std::sort(order.begin(), order.end(),
            [&](Eigen::Index a, Eigen::Index b) { return values[a] < values[b]; });
  for (const Eigen::Index k : order) {
    out.frequency_hz.push_back(std::sqrt(std::max(values[k], 0.0)) / (2.0 * std::numbers::pi));
    std::vector<Vec3>& mode = out.modes.emplace_back();
    for (std::size_t v = 0; v < mass_kg.size(); ++v) {
      const auto at = [&](std::size_t axis) {
        const Eigen::Index row = body.place[3 * v + axis];
        return row < 0 ? 0.0 : vectors(row, k) / std::sqrt(mass_kg[v]);
      };
      mode.push_back({at(0), at(1), at(2)});
    }
  }
  return out;
}

ModeShares measure_mode(const MotionModel& model, const std::vector<Vec3>& mode) {
  require(mode.size() == model.elastic.rest.size(), "one vector a vertex");
  ModeShares shares;
  MotionModel body = model;
  body.loads.clear();
  std::vector<Vec3> product(mode.size());
  multiply(build_stiffness(body), mode, product);
  for (std::size_t v = 0; v < mode.size(); ++v) {
    shares.stiffness += dot(mode[v], product[v]);
    shares.vertices += length_sq(mode[v]);
  }
  for (const auto& [a, b] : model.elastic.springs.springs) {
    const Vec3 along = model.elastic.rest[b] - model.elastic.rest[a];
    const double length_of = length(along);
    if (length_of == 0.0) continue;
    const double rate = dot(along, mode[b] - mode[a]) / length_of;
    shares.springs += rate * rate;
  }
  return shares;
}

}  // namespace palpate::dynamics

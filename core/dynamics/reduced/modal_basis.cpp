#include "core/dynamics/reduced/modal_basis.h"

#include <Spectra/SymGEigsShiftSolver.h>
#include <Eigen/Core>

#include <algorithm>
#include <stdexcept>
#include <string>

#include "core/base/component.h"
#include "core/base/error.h"
#include "core/dynamics/linear_algebra/vertex_field.h"

namespace palpate::dynamics {
namespace {

/// Puts numbers of free components to their nodes.
std::vector<Vec3> spread(const FreeNumbers& free, const double* numbers) {
  std::vector<Vec3> out(free.number.size() / 3);
  const auto at = [&](std::size_t c) { return free.number[c] == kNoIndex ? 0.0 : numbers[free.number[c]]; };
  for (std::size_t v = 0; v < out.size(); ++v) out[v] = {at(3 * v), at(3 * v + 1), at(3 * v + 2)};
  return out;
}

void gather(const FreeNumbers& free, std::span<const Vec3> field, double* numbers) {
  for (std::size_t c = 0; c < free.number.size(); ++c) {
    if (free.number[c] != kNoIndex) numbers[free.number[c]] = component(field[c / 3], c % 3);
  }
}

/// (K + S)^-1, as Spectra asks for it.
class InverseStiffness {
 public:
  using Scalar = double;  // NOLINT(readability-identifier-naming): Spectra's name
  InverseStiffness(const SymmetricFactor& factor, std::size_t size) : factor_(&factor), size_(size) {}
  Eigen::Index rows() const { return static_cast<Eigen::Index>(size_); }
  Eigen::Index cols() const { return rows(); }
  void set_shift(const double& shift) const { require(shift == 0.0, "no shift"); }
  void perform_op(const double* x, double* y) const {
    std::copy(x, x + size_, y);
    factor_->solve({y, size_});
  }

 private:
  const SymmetricFactor* factor_;
  std::size_t size_;
};

/// M between free components.
class MassProduct {
 public:
  using Scalar = double;  // NOLINT(readability-identifier-naming): Spectra's name
  MassProduct(const ElementMatrices& body, const FreeNumbers& free) : body_(&body), free_(&free) {}
  Eigen::Index rows() const { return static_cast<Eigen::Index>(free_->count); }
  Eigen::Index cols() const { return rows(); }
  void perform_op(const double* x, double* y) const {
    const std::vector<Vec3> field = spread(*free_, x);
    std::vector<Vec3> product(field.size());
    multiply_mass(*body_, field, product);
    gather(*free_, product, y);
  }

 private:
  const ElementMatrices* body_;
  const FreeNumbers* free_;
};

}  // namespace

HeldElements::HeldElements(const ElementMatrices& body, BlockMatrix with_supports,
                           std::vector<std::uint8_t> held, const FactorMaker& make_factor)
    : body_(body), stiffness_(std::move(with_supports)), held_(std::move(held)), free_(number_free(held_)) {
  factor_ = make_factor(lower_half(stiffness_, free_));
}

LowestModes HeldElements::find_modes(std::size_t count) const {
  const auto rows = static_cast<Eigen::Index>(free_.count);
  const auto wanted = static_cast<Eigen::Index>(count);
  if (count == 0 || wanted >= rows)
    throw InputError("modes", 0, "from 1 to " + std::to_string(std::max<Eigen::Index>(rows, 1) - 1),
                     std::to_string(count));
  constexpr Eigen::Index kRestarts = 1000;
  constexpr double kTolerance = 1e-10;
  InverseStiffness inverse(*factor_, free_.count);
  MassProduct mass(body_, free_);
  Spectra::SymGEigsShiftSolver<InverseStiffness, MassProduct, Spectra::GEigsMode::ShiftInvert> solver(
      inverse, mass, wanted, std::min(2 * wanted + 20, rows), 0.0);
  try {
    solver.init();
    solver.compute(Spectra::SortRule::LargestMagn, kRestarts, kTolerance, Spectra::SortRule::SmallestAlge);
  } catch (const std::runtime_error&) {
    throw UnavailableError("the lowest modes did not converge");
  }
  if (solver.info() != Spectra::CompInfo::Successful)
    throw UnavailableError("the lowest modes did not converge");
  const Eigen::VectorXd values = solver.eigenvalues();
  const Eigen::MatrixXd vectors = solver.eigenvectors();
  std::vector<Eigen::Index> order(count);
  for (std::size_t k = 0; k < count; ++k) order[k] = static_cast<Eigen::Index>(k);
  std::sort(order.begin(), order.end(),
            [&](Eigen::Index a, Eigen::Index b) { return values[a] < values[b]; });
  LowestModes out;
  for (const Eigen::Index k : order) {
    out.squares_per_s2.push_back(values[k]);
    out.modes.push_back(spread(free_, vectors.col(k).data()));
  }
  return out;
}

std::vector<Vec3> HeldElements::rest_under(std::span<const Vec3> force, std::span<const Vec3> held_by) const {
  std::vector<Vec3> by(force.size());
  for (std::size_t c = 0; c < free_.number.size(); ++c) {
    if (free_.number[c] != kNoIndex) continue;
    const double value = component(held_by[c / 3], c % 3);
    (c % 3 == 0 ? by[c / 3].x : c % 3 == 1 ? by[c / 3].y : by[c / 3].z) = value;
  }
  std::vector<Vec3> product(by.size());
  multiply(stiffness_, by, product);
  for (std::size_t v = 0; v < by.size(); ++v) product[v] = force[v] - product[v];
  std::vector<double> right(free_.count);
  gather(free_, product, right.data());
  factor_->solve(right);
  std::vector<Vec3> u = spread(free_, right.data());
  for (std::size_t v = 0; v < by.size(); ++v) u[v] = u[v] + by[v];
  return u;
}

}  // namespace palpate::dynamics

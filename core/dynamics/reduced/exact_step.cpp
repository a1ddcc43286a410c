#include "core/dynamics/reduced/exact_step.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <unsupported/Eigen/MatrixFunctions>

#include "core/base/error.h"
#include "core/dynamics/linear_algebra/signed_index.h"

namespace palpate::dynamics {
namespace {

using Matrix = Eigen::MatrixXd;
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

}  // namespace

ExactStep::ExactStep(const SmallSystem& system, double step_s)
    : modes_(system.modes()), loads_(system.loads), step_s_(step_s) {
  require(step_s > 0.0 && std::isfinite(step_s), "a step above zero");
  require(system.damping.size() == modes_ * modes_ && system.load.size() == modes_ * loads_ &&
              system.load_rate.size() == modes_ * loads_,
          "sizes of a small system");
  const Eigen::Index k = signed_index(modes_);
  const Eigen::Index l = signed_index(loads_);
  for (const double square : system.squares) scale_per_s_ = std::max(scale_per_s_, std::sqrt(square));
  // The state (scale eta, eta', s, h s'): the shares and their change are carried along.
  Matrix all = Matrix::Zero(2 * k + 2 * l, 2 * k + 2 * l);
  for (Eigen::Index i = 0; i < k; ++i) {
    all(i, k + i) = scale_per_s_;
    all(k + i, i) = -system.squares[static_cast<std::size_t>(i)] / scale_per_s_;
  }
  all.block(k, k, k, k) = -Eigen::Map<const RowMatrix>(system.damping.data(), k, k);
  all.block(k, 2 * k, k, l) = Eigen::Map<const RowMatrix>(system.load.data(), k, l);
  all.block(k, 2 * k + l, k, l) = Eigen::Map<const RowMatrix>(system.load_rate.data(), k, l) / step_s;
  for (Eigen::Index j = 0; j < l; ++j) all(2 * k + j, 2 * k + l + j) = 1.0 / step_s;
  const Matrix exponential = (step_s * all).exp();
  const Matrix map = exponential.topRows(2 * k);
  map_.assign(map.data(), map.data() + map.size());
  in_.resize(2 * (modes_ + loads_));
  out_.resize(2 * modes_);
}

void ExactStep::advance(std::span<double> eta, std::span<double> rate, std::span<const double> from,
                        std::span<const double> to) {
  require(eta.size() == modes_ && rate.size() == modes_ && from.size() == loads_ && to.size() == loads_,
          "sizes of a step");
  for (std::size_t i = 0; i < modes_; ++i) {
    in_[i] = scale_per_s_ * eta[i];
    in_[modes_ + i] = rate[i];
  }
  for (std::size_t j = 0; j < loads_; ++j) {
    in_[2 * modes_ + j] = from[j];
    in_[2 * modes_ + loads_ + j] = to[j] - from[j];
  }
  const Eigen::Index rows = signed_index(2 * modes_);
  const Eigen::Map<const Matrix> map(map_.data(), rows, signed_index(in_.size()));
  const Eigen::Map<const Eigen::VectorXd> in(in_.data(), signed_index(in_.size()));
  Eigen::Map<Eigen::VectorXd> out(out_.data(), rows);
  out.noalias() = map * in;
  for (std::size_t i = 0; i < modes_; ++i) {
    eta[i] = out_[i] / scale_per_s_;
    rate[i] = out_[modes_ + i];
  }
}

}  // namespace palpate::dynamics

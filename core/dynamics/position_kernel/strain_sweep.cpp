#include "core/dynamics/position_kernel/strain_sweep.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/error.h"
#include "core/dynamics/position_kernel/strain_columns.h"

namespace palpate::dynamics {
namespace {

/// The number `k` of a lane of a group of `numbers` a group.
double& lane_number(LargeVector<double>& of, std::size_t numbers, std::size_t lane_place, std::size_t k) {
  const std::size_t group = lane_place / kGroupDomains;
  return of[kGroupDomains * (numbers * group + k) + lane_place % kGroupDomains];
}

/// (1 + factor S G S)^-1 of a domain's six strains.
Matrix6 symmetric_correction(const StrainOperator& op, Index domain, const StrainStep& step,
                             const PositionRows& rows, double factor) {
  const double root = std::sqrt(op.volume_m3[domain]);
  Matrix6 s = Matrix6::Zero();
  s.topLeftCorner<3, 3>().setConstant(root * step.root_sum);
  for (int k = 0; k < 3; ++k) {
    s(k, k) += root * step.root_even;
    s(3 + k, 3 + k) = root * step.root_shear;
  }
  Matrix6 g = Matrix6::Zero();
  for (Index k = op.offsets[domain]; k < op.offsets[domain + 1]; ++k) {
    const Matrix36 gradients = strain_gradients(op.gradients[k]) * s;
    g += rows[kRowNumbers * op.vertices[k] + 3] * (gradients.transpose() * gradients);
  }
  return (Matrix6::Identity() + factor * g).inverse();
}

/// Writes the six numbers of a symmetric matrix from number `first` on.
void write_symmetric(const Mat3& a, LargeVector<double>& to, std::size_t numbers, std::size_t lane_place,
                     std::size_t first) {
  const std::array<double, 6> six{a(0, 0), a(1, 1), a(2, 2), a(1, 2), a(0, 2), a(0, 1)};
  for (std::size_t k = 0; k < six.size(); ++k) lane_number(to, numbers, lane_place, first + k) = six[k];
}

}  // namespace

bool can_sweep_in_lanes(const StrainTerm& term) {
  return term.law != StrainLaw::kNeoHookean && term.moduli.mu_pa >= 0.0 &&
         2.0 * term.moduli.mu_pa + 3.0 * term.moduli.lambda_pa >= 0.0;
}

StrainSweep::StrainSweep(const StrainTerm& term, std::size_t vertex_count, std::span<const Index> chosen,
                         std::span<const std::vector<Index>> colours)
    : term_(&term) {
  require(can_sweep_in_lanes(term), "moduli with a square root");
  step_.law = term.law;
  for (const std::vector<Index>& colour : colours) {
    std::vector<Index> domains;
    domains.reserve(colour.size());
    for (const Index place : colour) {
      if (!term.op.vertices_of(chosen[place]).empty()) domains.push_back(chosen[place]);
    }
    const auto size_of = [&](Index s) { return term.op.vertices_of(s).size(); };
    std::stable_sort(domains.begin(), domains.end(),
                     [&](Index a, Index b) { return size_of(a) > size_of(b); });
    for (std::size_t first = 0; first < domains.size(); first += kGroupDomains) {
      const std::size_t count = std::min(kGroupDomains, domains.size() - first);
      pack({domains.data() + first, count}, static_cast<std::uint32_t>(kRowNumbers * vertex_count));
    }
  }
  weights_.resize(kGroupDomains * count_weights(term.law) * groups_.size());
  kept_.resize(kGroupDomains * count_kept(term.law) * groups_.size());
}

void StrainSweep::pack(std::span<const Index> domains, std::uint32_t padding) {
  const StrainOperator& op = term_->op;
  const std::size_t n = op.vertices_of(domains.front()).size();
  groups_.push_back({n, values_.size(), at_.size()});
  values_.resize(values_.size() + kGroupDomains * (3 * n - 1));
  at_.resize(at_.size() + kGroupDomains * n, padding);
  double* const values = values_.data() + groups_.back().values;
  std::uint32_t* const at = at_.data() + groups_.back().at;
  for (std::size_t lane = 0; lane < kGroupDomains; ++lane) {
    const Index s = lane < domains.size() ? domains[lane] : kNoIndex;
    domain_of_lane_.push_back(s);
    if (s == kNoIndex) continue;
    values[lane] = op.volume_m3[s];
    values[kGroupDomains + lane] = std::sqrt(op.volume_m3[s]);
    const std::span<const Index> vertices = op.vertices_of(s);
    for (std::size_t k = 0; k < vertices.size(); ++k) {
      at[kGroupDomains * k + lane] = static_cast<std::uint32_t>(kRowNumbers * vertices[k]);
      if (k == 0) continue;
      const Vec3& gradient = op.gradients_of(s)[k];
      double* const g = values + kGroupDomains * (3 * k - 1) + lane;
      g[0] = gradient.x;
      g[kGroupDomains] = gradient.y;
      g[2 * kGroupDomains] = gradient.z;
    }
  }
}

void StrainSweep::prepare(double step_s, double damping_s, const PositionRows& rows) {
  const Moduli& moduli = term_->moduli;
  const double bulk_pa = moduli.lambda_pa + moduli.mu_pa;
  const double h_sq = step_s * step_s;
  step_.shear = h_sq * moduli.mu_pa;
  step_.bulk = h_sq * bulk_pa;
  step_.rest = bulk_pa > 0.0 ? moduli.mu_pa / bulk_pa : 0.0;
  step_.step_sq = h_sq;
  step_.damping = step_s * damping_s;
  step_.root_even = std::sqrt(2.0 * moduli.mu_pa);
  step_.root_sum = (std::sqrt(2.0 * moduli.mu_pa + 3.0 * moduli.lambda_pa) - step_.root_even) / 3.0;
  step_.root_shear = std::sqrt(moduli.mu_pa);
  const StrainOperator& op = term_->op;
  const std::size_t numbers = count_weights(step_.law);
  for (std::size_t place = 0; place < domain_of_lane_.size(); ++place) {
    const Index s = domain_of_lane_[place];
    if (s == kNoIndex) continue;
    if (step_.law != StrainLaw::kStableNeoHookean) {
      const Matrix6 c = symmetric_correction(op, s, step_, rows, h_sq + step_.damping);
      for (std::size_t i = 0; i < 6; ++i) {
        for (std::size_t j = 0; j <= i; ++j)
          lane_number(weights_, numbers, place, triangle_at(i, j)) =
              c(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      }
      continue;
    }
    Mat3 a;
    for (Index k = op.offsets[s]; k < op.offsets[s + 1]; ++k)
      a += rows[kRowNumbers * op.vertices[k] + 3] * outer(op.gradients[k], op.gradients[k]);
    const Mat3 system = kIdentity + (2.0 * h_sq * op.volume_m3[s] * moduli.mu_pa) * a;
    const Mat3 m = (1.0 / determinant(system)) * cofactors(system);
    write_symmetric(a, weights_, numbers, place, 0);
    write_symmetric(m, weights_, numbers, place, 6);
    write_symmetric(multiply(m, a), weights_, numbers, place, 12);
  }
}

void StrainSweep::sweep(const SweptRows& rows, const SweepOrder& order, bool with_avx2) {
  const StrainRun run{step_, groups_, values_.data(), at_.data(), weights_.data(), kept_.data()};
  if (with_avx2) {
    sweep_strains_avx2(run, rows, order);
  } else {
    sweep_strains(run, rows, order);
  }
}

}  // namespace palpate::dynamics

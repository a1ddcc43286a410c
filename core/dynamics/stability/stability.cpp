#include "core/dynamics/stability/stability.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <span>

#include "core/base/error.h"
#include "core/dynamics/stability/extreme_eigen.h"

namespace palpate::dynamics {
namespace {

constexpr double kNoBound = std::numeric_limits<double>::infinity();

/// Where the ray h lambda leaves the region |R| <= 1 of the classical Runge-Kutta method, in |h lambda|.
double leave_runge_kutta_region(const std::complex<double>& direction) {
  const auto grows = [&](double r) {
    const std::complex<double> z = r * direction;
    const std::complex<double> factor = 1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0)));
    return std::abs(factor) > 1.0 + 1e-13;
  };
  constexpr double kFirst = 2.0;  // no ray of the left half-plane leaves before 2.6
  constexpr double kScan = 0.01;
  double low = kFirst;
  while (!grows(low + kScan)) low += kScan;
  double high = low + kScan;
  for (int k = 0; k < 50; ++k) {
    const double middle = 0.5 * (low + high);
    (grows(middle) ? high : low) = middle;
  }
  return low;
}

double runge_kutta_step(double omega, double damping) {
  const double discriminant = damping * damping - 4.0 * omega * omega;
  constexpr int kFar = -600;
  if (!std::isfinite(discriminant))  // the squares are too large; steps go as the inverse of the rates
    return std::ldexp(runge_kutta_step(std::ldexp(omega, kFar), std::ldexp(damping, kFar)), kFar);
  if (discriminant >= 0.0) {  // both real; the faster one binds
    const double rate = 0.5 * (damping + std::sqrt(discriminant));
    return rate > 0.0 ? leave_runge_kutta_region(-1.0) / rate : kNoBound;
  }
  const std::complex<double> lambda{-0.5 * damping, 0.5 * std::sqrt(-discriminant)};
  return leave_runge_kutta_region(lambda / std::abs(lambda)) / std::abs(lambda);
}

double explicit_euler_step(double omega, double damping) {
  if (omega == 0.0) return damping > 0.0 ? 2.0 / damping : kNoBound;
  const double oscillating = damping / (omega * omega);
  const double discriminant = damping * damping - 4.0 * omega * omega;
  return discriminant >= 0.0 ? std::min(oscillating, 4.0 / (damping + std::sqrt(discriminant))) : oscillating;
}

/// K and D of a body at rest, scaled to M^-1/2 K M^-1/2, without held components.
struct ScaledBody {
  BlockMatrix stiffness;
  BlockMatrix damping;
  double volume_stiffness = 0.0;  ///< norm of the volume force's part
};

void scale_by_mass(std::span<const double> mass_kg, const std::vector<std::uint8_t>& held,
                   BlockMatrix& matrix) {
  for (std::size_t v = 0; v < matrix.rows(); ++v) {
    for (std::size_t k = matrix.offsets[v]; k < matrix.offsets[v + 1]; ++k) {
      const Index w = matrix.columns[k];
      const double scale = 1.0 / std::sqrt(mass_kg[v] * mass_kg[w]);
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) {
          const bool is_out = ((static_cast<unsigned>(held[v]) >> i) & 1U) != 0 ||
                              ((static_cast<unsigned>(held[w]) >> j) & 1U) != 0;
          matrix.blocks[k](i, j) = is_out ? 0.0 : scale * matrix.blocks[k](i, j);
        }
      }
    }
  }
}

double norm_of_volume_force(const MotionModel& model, std::span<const Vec3> u) {
  if (!model.elastic.volume_force) return 0.0;
  const VolumeForceTangent tangent =
      differentiate_volume_force(*model.elastic.volume_force, model.elastic.rest, u);
  double directions = 0.0;
  double gradients = 0.0;
  for (std::size_t v = 0; v < u.size(); ++v) {
    directions += length_sq(tangent.direction[v]) / model.mass_kg[v];
    gradients += length_sq(tangent.volume_gradient[v]) / model.mass_kg[v];
  }
  return model.elastic.volume_force->stiffness_n_per_m3 * std::sqrt(directions * gradients);
}

void scale_body(std::span<const double> mass_kg, const std::vector<std::uint8_t>& held, ScaledBody& body) {
  for (BlockMatrix* matrix : {&body.stiffness, &body.damping}) {
    scale_by_mass(mass_kg, held, *matrix);
    const bool is_finite = std::all_of(matrix->blocks.begin(), matrix->blocks.end(), [](const Mat3& block) {
      return std::isfinite(contract(block, block));
    });
    if (!is_finite)
      throw InputError("model", 0, "stiffness and damping over mass that are finite, with their squares",
                       "numbers beyond the range of double precision");
  }
}

ScaledBody build_scaled_body(const MotionModel& model, std::span<const Vec3> u) {
  const MotionForces forces(model, 1);
  ScaledBody body{build_motion_pattern(model), {}, norm_of_volume_force(model, u)};
  body.damping = body.stiffness;
  add_motion_stiffness(model, u, TangentKind::kExact, body.stiffness);
  add_changing_damping(model, u, body.damping);
  add_constant_damping(model, body.damping);
  scale_body(model.mass_kg, forces.held_bits(), body);
  return body;
}

/// Looks for the vectors that bound the step.
class WorstVectors {
 public:
  WorstVectors(const ScaledBody& body, IntegratorKind kind, int threads)
      : body_(body), kind_(kind), threads_(threads), sum_(body.stiffness), product_(sum_.rows()) {}

  /// The bound by the worst vector of a K + b D; infinity if none was found.
  double try_worst(double a, double b) {
    for (std::size_t k = 0; k < sum_.blocks.size(); ++k)
      sum_.blocks[k] = a * body_.stiffness.blocks[k] + b * body_.damping.blocks[k];
    ExtremeEigen worst = find_largest_eigenvalue(sum_, threads_, last_);
    found_.products += worst.products;
    found_.converged = found_.converged && worst.converged;
    if (!worst.converged) return kNoBound;
    const double stiffness = quotient(body_.stiffness, worst.vector) + body_.volume_stiffness;
    const double damping = quotient(body_.damping, worst.vector);
    found_.stiffness_max_per_s2 = std::max(found_.stiffness_max_per_s2, stiffness);
    found_.damping_max_per_s = std::max(found_.damping_max_per_s, damping);
    last_ = std::move(worst.vector);  // of stiffness and of damping it is mostly the same
    return stable_step_of_mode(kind_, std::sqrt(std::max(stiffness, 0.0)), std::max(damping, 0.0));
  }

  /// Follows the worst vector of h K + c D (or of its opposite) until h settles.
  double settle(double step, double of_stiffness, double of_damping) {
    constexpr int kMostRounds = 10;
    constexpr double kSettled = 1e-4;
    for (int round = 0; round < kMostRounds && step > 0.0 && std::isfinite(step); ++round) {
      const double next = std::min(step, try_worst(step * of_stiffness, of_damping));
      const bool is_settled = next >= (1.0 - kSettled) * step;
      step = next;
      if (is_settled) return step;
    }
    return step;
  }

  /// The bound by the fastest roots themselves, for Runge-Kutta.
  double try_fastest_rates() {
    const FastestRates fastest =
        find_fastest_rates(body_.stiffness, body_.damping, found_.stiffness_max_per_s2, threads_);
    found_.products += fastest.products;
    found_.converged = found_.converged && fastest.converged;
    double step = kNoBound;
    for (const std::complex<double>& lambda : fastest.lambda) {
      const double size = std::abs(lambda);
      if (size > 0.0 && lambda.real() <= 0.0)
        step = std::min(step, leave_runge_kutta_region(lambda / size) / size);
    }
    return step;
  }

  /// The least bound of explicit Euler over all roots, or over the fastest of a larger body; infinity if
  /// none were found.
  double try_roots_of_explicit_euler() {
    const FastestRates rates = is_small() ? find_all_rates(body_.stiffness, body_.damping)
                                          : find_fastest_rates(body_.stiffness, body_.damping,
                                                               found_.stiffness_max_per_s2, threads_);
    found_.products += rates.products;
    if (!rates.converged) return kNoBound;
    constexpr double kNoRate = 1e-6;  // of the fastest: a body's free motions, of rate 0
    double fastest = 0.0;
    for (const std::complex<double>& lambda : rates.lambda) fastest = std::max(fastest, std::abs(lambda));
    double step = kNoBound;
    for (const std::complex<double>& lambda : rates.lambda) {
      if (std::abs(lambda) > kNoRate * fastest)
        step = std::min(step, std::max(0.0, -2.0 * lambda.real() / std::norm(lambda)));
    }
    return step;
  }

  /// Of the vector that was found last, whose mode mostly sets the bound.
  Index find_limiting_vertex() const {
    if (last_.empty()) return kNoIndex;
    const auto most = std::max_element(
        last_.begin(), last_.end(), [](const Vec3& a, const Vec3& b) { return length_sq(a) < length_sq(b); });
    return static_cast<Index>(most - last_.begin());
  }

  /// Whether all roots can be had.
  bool is_small() const {
    constexpr std::size_t kMostVertices = 120;
    return body_.stiffness.rows() <= kMostVertices && body_.volume_stiffness == 0.0;
  }

  const StableStep& found() const { return found_; }

 private:
  double quotient(const BlockMatrix& matrix, const std::vector<Vec3>& v) {
    multiply(matrix, v, product_, threads_);
    double sum = 0.0;
    for (std::size_t i = 0; i < v.size(); ++i) sum += dot(v[i], product_[i]);
    return sum;
  }

  const ScaledBody& body_;
  IntegratorKind kind_;
  int threads_;
  BlockMatrix sum_;
  std::vector<Vec3> product_;
  std::vector<Vec3> last_;
  StableStep found_;
};

bool is_zero(const BlockMatrix& matrix) {
  return std::all_of(matrix.blocks.begin(), matrix.blocks.end(),
                     [](const Mat3& block) { return contract(block, block) == 0.0; });
}

StableStep find_stable_step(const ScaledBody& body, IntegratorKind kind, int threads) {
  WorstVectors worst(body, kind, threads);
  const bool has_damping = !is_zero(body.damping);
  const bool has_stiffness = !is_zero(body.stiffness);
  double step = kNoBound;
  if (has_stiffness) step = worst.try_worst(1.0, 0.0);
  if (has_damping) step = std::min(step, worst.try_worst(0.0, 1.0));
  double at_most = step;
  if (std::isfinite(step) && has_damping && has_stiffness) {
    if (kind == IntegratorKind::kRungeKutta4) {
      const double by_rates = worst.try_fastest_rates();
      step = at_most = std::isfinite(by_rates) ? by_rates : step;
    } else if (kind == IntegratorKind::kExplicitEuler) {
      at_most = worst.try_roots_of_explicit_euler();
      step = worst.is_small() ? at_most : worst.settle(worst.settle(step, 1.0, 2.0), 1.0, -1.0);
    } else {
      step = at_most = worst.settle(step, 1.0, kind == IntegratorKind::kVelocityVerlet ? 4.0 : 2.0);
    }
  }
  StableStep out = worst.found();
  out.step_s = std::min(step, at_most);
  out.step_at_most_s = at_most;
  out.limiting_vertex = worst.find_limiting_vertex();
  return out;
}

}  // namespace

double stable_step_of_mode(IntegratorKind kind, double omega_per_s, double damping_per_s) {
  const double w = omega_per_s;
  const double d = damping_per_s;
  require(w >= 0.0 && d >= 0.0 && std::isfinite(w) && std::isfinite(d), "a mode is finite and not negative");
  switch (kind) {
    case IntegratorKind::kExplicitEuler:
      return explicit_euler_step(w, d);
    case IntegratorKind::kSymplecticEuler:
      return 4.0 / (d + std::hypot(d, 2.0 * w));
    case IntegratorKind::kVelocityVerlet:
      return 2.0 / (d + std::hypot(d, w));
    case IntegratorKind::kRungeKutta4:
      return runge_kutta_step(w, d);
    case IntegratorKind::kImplicitEuler:
    case IntegratorKind::kPrefactored:
    case IntegratorKind::kBackwardEuler:
    case IntegratorKind::kBdf2:
    case IntegratorKind::kTrapezoidal:
    case IntegratorKind::kXpbd:
    case IntegratorKind::kVbd:
      return kNoBound;
  }
  throw ContractError("stable_step_of_mode: unknown integrator");
}

StableStep predict_stable_step_at(const MotionModel& model, IntegratorKind kind, std::span<const Vec3> u,
                                  int threads) {
  require(u.size() == model.elastic.rest.size(), "one displacement a vertex");
  return find_stable_step(build_scaled_body(model, u), kind, threads);
}

StableStep predict_stable_step(const BlockMatrix& stiffness, const BlockMatrix& damping,
                               std::span<const double> mass_kg, IntegratorKind kind, int threads) {
  require(stiffness.rows() == mass_kg.size() && damping.offsets == stiffness.offsets &&
              damping.columns == stiffness.columns,
          "one pattern and one mass a row");
  ScaledBody body{stiffness, damping, 0.0};
  scale_body(mass_kg, std::vector<std::uint8_t>(mass_kg.size()), body);
  return find_stable_step(body, kind, threads);
}

StableStep predict_stable_step(const MotionModel& model, IntegratorKind kind, int threads) {
  return predict_stable_step_at(model, kind, std::vector<Vec3>(model.elastic.rest.size()), threads);
}

StableStep bound_stable_step(const MotionModel& model, IntegratorKind kind) {
  const ScaledBody body = build_scaled_body(model, std::vector<Vec3>(model.elastic.rest.size()));
  StableStep out;
  out.step_s = kNoBound;
  const auto row_sum = [](const BlockMatrix& matrix, std::size_t v, std::size_t i) {
    double sum = 0.0;
    for (std::size_t k = matrix.offsets[v]; k < matrix.offsets[v + 1]; ++k) {
      for (std::size_t j = 0; j < 3; ++j) sum += std::abs(matrix.blocks[k](i, j));
    }
    return sum;
  };
  for (std::size_t v = 0; v < body.stiffness.rows(); ++v) {
    for (std::size_t i = 0; i < 3; ++i) {
      const double stiffness = row_sum(body.stiffness, v, i) + body.volume_stiffness;
      const double damping = row_sum(body.damping, v, i);
      out.stiffness_max_per_s2 = std::max(out.stiffness_max_per_s2, stiffness);
      out.damping_max_per_s = std::max(out.damping_max_per_s, damping);
      if (kind != IntegratorKind::kSymplecticEuler && kind != IntegratorKind::kVelocityVerlet) continue;
      const double step = stable_step_of_mode(kind, std::sqrt(stiffness), damping);
      if (!(step < out.step_s)) continue;
      out.step_s = step;
      out.limiting_vertex = static_cast<Index>(v);
    }
  }
  if (kind == IntegratorKind::kExplicitEuler) out.step_s = 0.0;
  if (kind == IntegratorKind::kRungeKutta4) {
    // All roots of lambda^2 + d lambda + omega^2 lie within this radius, and the half-disc of radius 2.6 is
    // in the region of stability.
    constexpr double kHalfDisc = 2.6;
    const double radius =
        0.5 * (out.damping_max_per_s +
               std::hypot(out.damping_max_per_s, 2.0 * std::sqrt(out.stiffness_max_per_s2)));
    out.step_s = radius > 0.0 ? kHalfDisc / radius : kNoBound;
  }
  out.step_at_most_s = kNoBound;
  return out;
}

}  // namespace palpate::dynamics

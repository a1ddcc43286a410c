#include "core/judge/motion_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>

#include "core/base/error.h"

namespace palpate::judge {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;

/// The sample behind `at`, at least 1.
std::size_t place_after(std::span<const double> time, double at) {
  const auto after = std::upper_bound(time.begin(), time.end(), at);
  return std::clamp<std::size_t>(static_cast<std::size_t>(after - time.begin()), 1, time.size() - 1);
}

template <typename Interpolate>
std::vector<double> sample(std::span<const double> time, std::span<const double> value,
                           std::span<const double> at, const Interpolate& interpolate) {
  require(!time.empty() && time.size() == value.size(), "one value a time, at least one");
  std::vector<double> out;
  out.reserve(at.size());
  for (const double t : at) {
    if (t <= time.front() || time.size() == 1) {
      out.push_back(value.front());
    } else if (t >= time.back()) {
      out.push_back(value.back());
    } else {
      out.push_back(interpolate(place_after(time, t), t));
    }
  }
  return out;
}

double straight(std::span<const double> time, std::span<const double> value, std::size_t k, double t) {
  const double s = (t - time[k - 1]) / (time[k] - time[k - 1]);
  return value[k - 1] + s * (value[k] - value[k - 1]);
}

using Matrix3 = std::array<std::array<double, 3>, 3>;
using Vector3 = std::array<double, 3>;

/// Gaussian elimination with pivoting of a symmetric system; false if it is singular.
bool solve(Matrix3 a, Vector3 b, Vector3& x) {
  for (std::size_t k = 0; k < 3; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < 3; ++i) {
      if (std::fabs(a[i][k]) > std::fabs(a[pivot][k])) pivot = i;
    }
    if (std::fabs(a[pivot][k]) <= 1e-300) return false;
    std::swap(a[k], a[pivot]);
    std::swap(b[k], b[pivot]);
    for (std::size_t i = k + 1; i < 3; ++i) {
      const double factor = a[i][k] / a[k][k];
      for (std::size_t j = k; j < 3; ++j) a[i][j] -= factor * a[k][j];
      b[i] -= factor * b[k];
    }
  }
  for (std::size_t k = 3; k-- > 0;) {
    x[k] = b[k];
    for (std::size_t j = k + 1; j < 3; ++j) x[k] -= a[k][j] * x[j];
    x[k] /= a[k][k];
  }
  return true;
}

/// A signal in a window, with its mean taken off, and the best fit for each frequency and decay.
class Window {
 public:
  Window(std::span<const double> time, std::span<const double> value, double from, double to) {
    for (std::size_t k = 0; k < time.size(); ++k) {
      if (time[k] < from || time[k] > to) continue;
      time_.push_back(time[k] - from);
      value_.push_back(value[k]);
      mean_ += value[k];
    }
    if (time_.empty()) return;
    mean_ /= static_cast<double>(time_.size());
    double largest = 0.0;
    for (double& v : value_) {
      largest = std::max(largest, std::fabs(v));
      v -= mean_;
      spread_ += v * v;
    }
    const double rounding = 1e-13 * largest;
    if (spread_ <= rounding * rounding * static_cast<double>(time_.size())) spread_ = 0.0;
  }

  bool is_empty() const { return time_.size() < 8 || spread_ == 0.0; }
  double length() const { return time_.back() - time_.front(); }
  std::size_t samples() const { return time_.size(); }

  /// Sum of squares that is left; fills `fit` if it is there.
  double left_over(double omega, double decay, Oscillation* fit = nullptr) const {
    Matrix3 normal{};
    Vector3 right{};
    const auto basis = [&](double t) {
      const double size = std::exp(-decay * t);
      return Vector3{1.0, size * std::cos(omega * t), size * std::sin(omega * t)};
    };
    for (std::size_t k = 0; k < time_.size(); ++k) {
      const Vector3 b = basis(time_[k]);
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) normal[i][j] += b[i] * b[j];
        right[i] += b[i] * value_[k];
      }
    }
    Vector3 c{};
    if (!solve(normal, right, c)) return std::numeric_limits<double>::infinity();
    double left = 0.0;
    for (std::size_t k = 0; k < time_.size(); ++k) {
      const Vector3 b = basis(time_[k]);
      const double r = value_[k] - c[0] * b[0] - c[1] * b[1] - c[2] * b[2];
      left += r * r;
    }
    if (!std::isfinite(left)) return std::numeric_limits<double>::infinity();
    if (fit != nullptr) {
      *fit = {mean_ + c[0], std::hypot(c[1], c[2]),   std::atan2(-c[2], c[1]), omega / kTwoPi,
              decay,        std::sqrt(left / spread_)};
    }
    return left;
  }

 private:
  std::vector<double> time_;
  std::vector<double> value_;
  double mean_ = 0.0;
  double spread_ = 0.0;
};

}  // namespace

std::vector<double> sample_straight(std::span<const double> time_s, std::span<const double> value,
                                    std::span<const double> at_s) {
  return sample(time_s, value, at_s, [&](std::size_t k, double t) { return straight(time_s, value, k, t); });
}

std::vector<double> sample_smooth(std::span<const double> time_s, std::span<const double> value,
                                  std::span<const double> at_s) {
  return sample(time_s, value, at_s, [&](std::size_t k, double t) {
    if (time_s.size() < 4) return straight(time_s, value, k, t);
    const std::size_t first = std::clamp<std::size_t>(k, 2, time_s.size() - 2) - 2;
    double sum = 0.0;
    for (std::size_t i = first; i < first + 4; ++i) {
      double weight = value[i];
      for (std::size_t j = first; j < first + 4; ++j) {
        if (j != i) weight *= (t - time_s[j]) / (time_s[i] - time_s[j]);
      }
      sum += weight;
    }
    return sum;
  });
}

std::optional<double> history_error(std::span<const double> time_s,
                                    std::span<const std::vector<double>> signal,
                                    std::span<const std::vector<double>> reference) {
  require(signal.size() == reference.size(), "as many components as the reference has");
  double error = 0.0;
  double size = 0.0;
  for (std::size_t c = 0; c < signal.size(); ++c) {
    require(signal[c].size() == time_s.size() && reference[c].size() == time_s.size(), "one value a time");
    for (std::size_t k = 0; k + 1 < time_s.size(); ++k) {
      const double half = 0.5 * (time_s[k + 1] - time_s[k]);
      for (const std::size_t i : {k, k + 1}) {
        const double difference = signal[c][i] - reference[c][i];
        error += half * difference * difference;
        size += half * reference[c][i] * reference[c][i];
      }
    }
  }
  if (size == 0.0) return std::nullopt;
  return std::sqrt(error / size);
}

std::optional<Vec3> main_direction(std::span<const Vec3> path) {
  if (path.empty()) return std::nullopt;
  Vec3 mean;
  for (const Vec3& p : path) mean = mean + p;
  mean = (1.0 / static_cast<double>(path.size())) * mean;
  Vec3 farthest;
  for (const Vec3& p : path) {
    if (length_sq(p - mean) > length_sq(farthest)) farthest = p - mean;
  }
  if (!(length(farthest) > 1e-13 * length(mean))) return std::nullopt;
  constexpr int kRounds = 200;  // the power method, from the farthest point
  Vec3 direction = (1.0 / length(farthest)) * farthest;
  for (int round = 0; round < kRounds; ++round) {
    Vec3 next;
    for (const Vec3& p : path) next = next + dot(p - mean, direction) * (p - mean);
    direction = (1.0 / length(next)) * next;
  }
  const double largest = std::max({direction.x, direction.y, direction.z});
  const double smallest = std::min({direction.x, direction.y, direction.z});
  return (largest >= -smallest ? 1.0 : -1.0) * direction;
}

std::optional<Oscillation> fit_oscillation(std::span<const double> time_s, std::span<const double> value,
                                           double from_s, double to_s, std::optional<double> near_hz) {
  require(time_s.size() == value.size(), "one value a time");
  const Window window(time_s, value, from_s, to_s);
  if (window.is_empty()) return std::nullopt;
  const double bin = kTwoPi / window.length();
  const double low = near_hz ? 0.5 * kTwoPi * *near_hz : 0.75 * bin;
  const double high =
      near_hz ? 1.5 * kTwoPi * *near_hz : bin * std::min(0.25 * static_cast<double>(window.samples()), 200.0);
  double omega = low;
  double decay = 1.0 / window.length();
  double best = std::numeric_limits<double>::infinity();
  for (double w = low; w <= high; w += 0.1 * bin) {
    for (const double d : {0.0, 3.0 / window.length()}) {
      const double left = window.left_over(w, d);
      if (left < best) std::tie(best, omega, decay) = std::tuple{left, w, d};
    }
  }
  double omega_step = 0.05 * bin;
  double decay_step = 1.0 / window.length();
  constexpr int kHalvings = 60;
  for (int halving = 0; halving < kHalvings;) {  // pattern search
    bool moved = false;
    for (const auto& [dw, dd] :
         {std::pair{omega_step, 0.0}, {-omega_step, 0.0}, {0.0, decay_step}, {0.0, -decay_step}}) {
      const double left = omega + dw > 0.0 ? window.left_over(omega + dw, decay + dd) : best;
      if (left < best) {
        std::tie(best, omega, decay) = std::tuple{left, omega + dw, decay + dd};
        moved = true;
      }
    }
    if (moved) continue;
    omega_step *= 0.5;
    decay_step *= 0.5;
    ++halving;
  }
  Oscillation fit;
  window.left_over(omega, decay, &fit);
  return fit;
}

OscillationError compare_oscillations(const Oscillation& found, const Oscillation& reference) {
  require(reference.amplitude > 0.0 && reference.frequency_hz > 0.0, "a reference that oscillates");
  constexpr double kLeastDampingRatio = 1e-3;
  OscillationError error;
  error.amplitude = found.amplitude / reference.amplitude - 1.0;
  const double turn = std::remainder(found.phase_rad - reference.phase_rad, kTwoPi);
  error.phase_deg = turn * 360.0 / kTwoPi;
  if (error.phase_deg <= -180.0) error.phase_deg += 360.0;
  error.frequency = found.frequency_hz / reference.frequency_hz - 1.0;
  const auto ratio = [](const Oscillation& o) { return o.decay_per_s / (kTwoPi * o.frequency_hz); };
  error.damping_ratio = ratio(found) - ratio(reference);
  if (ratio(reference) >= kLeastDampingRatio) error.decay = found.decay_per_s / reference.decay_per_s - 1.0;
  return error;
}

std::vector<double> frequency_errors(std::span<const double> found_hz, std::span<const double> reference_hz,
                                     double rigid_hz) {
  require(found_hz.size() == reference_hz.size(), "as many frequencies as the reference has");
  std::vector<double> errors;
  for (std::size_t k = 0; k < found_hz.size(); ++k) {
    if (reference_hz[k] > rigid_hz) errors.push_back(found_hz[k] / reference_hz[k] - 1.0);
  }
  return errors;
}

}  // namespace palpate::judge

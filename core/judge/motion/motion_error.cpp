#include "core/judge/motion/motion_error.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace palpate::judge {
namespace {

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

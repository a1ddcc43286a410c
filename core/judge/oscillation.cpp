#include "core/judge/oscillation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>

#include "core/base/error.h"

namespace palpate::judge {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;

/// Gaussian elimination with pivoting of a square system; nothing if it is singular.
std::optional<std::vector<double>> solve(std::vector<std::vector<double>> a, std::vector<double> b) {
  const std::size_t n = b.size();
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < n; ++i) {
      if (std::fabs(a[i][k]) > std::fabs(a[pivot][k])) pivot = i;
    }
    if (!(std::fabs(a[pivot][k]) > 1e-300)) return std::nullopt;
    std::swap(a[k], a[pivot]);
    std::swap(b[k], b[pivot]);
    for (std::size_t i = k + 1; i < n; ++i) {
      const double factor = a[i][k] / a[k][k];
      for (std::size_t j = k; j < n; ++j) a[i][j] -= factor * a[k][j];
      b[i] -= factor * b[k];
    }
  }
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t j = k + 1; j < n; ++j) b[k] -= a[k][j] * b[j];
    b[k] /= a[k][k];
  }
  return b;
}

/// One oscillation as exp(-decay t) (a cos(omega t) + b sin(omega t)).
struct Term {
  double a = 0.0;
  double b = 0.0;
  double omega = 0.0;
  double decay = 0.0;
};

struct Model {
  double offset = 0.0;
  std::vector<Term> terms;
  double left = std::numeric_limits<double>::infinity();  ///< sum of squares that it leaves over
};

/// A signal in a window, with its mean taken off.
class Fitting {
 public:
  Fitting(std::span<const double> time, std::span<const double> value, const FitWindow& window) {
    for (std::size_t k = 0; k < time.size(); ++k) {
      if (time[k] < window.from_s || time[k] > window.to_s) continue;
      time_.push_back(time[k] - window.from_s);
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

  /// Adds one oscillation to a model: the best of a scan, in what the model leaves over.
  Model add_term(const Model& model) const {
    const double bin = kTwoPi / time_.back();
    const double high = bin * std::min(0.25 * static_cast<double>(time_.size()), 200.0);
    const std::vector<double> rest = left_over(model);
    Term best;
    double most = -1.0;
    const auto count = static_cast<int>((high - 0.5 * bin) / (0.1 * bin)) + 1;
    for (int k = 0; k < count; ++k) {
      const double omega = (0.5 + 0.1 * k) * bin;
      for (const double decay : {0.0, 3.0 / time_.back()}) {
        const Term term{0.0, 0.0, omega, decay};
        const double gain = gain_of(term, rest);
        if (gain > most) std::tie(most, best) = std::pair{gain, term};
      }
    }
    Model more = model;
    more.terms.push_back(best);
    return refine(std::move(more));
  }

  /// The nearest best fit: offset and a, b first, which are linear, then all together.
  Model refine(Model model) const {
    constexpr int kRounds = 200;
    set_linear(model);
    model.left = sum_of_squares(model);
    double damping = 1e-3;
    for (int round = 0; round < kRounds && damping < 1e12; ++round) {
      const Model next = step(model, damping);
      if (next.left < model.left) {
        const bool is_settled = model.left - next.left <= 1e-16 * model.left;
        model = next;
        damping = std::max(0.1 * damping, 1e-15);
        if (is_settled) break;
      } else {
        damping *= 10.0;
      }
    }
    return model;
  }

  OscillationFit describe(const Model& model) const {
    OscillationFit fit{mean_ + model.offset, {}, std::sqrt(model.left / spread_)};
    for (const Term& term : model.terms) {
      const double sign = term.omega < 0.0 ? -1.0 : 1.0;
      fit.oscillations.push_back({std::hypot(term.a, term.b), std::atan2(-sign * term.b, term.a),
                                  sign * term.omega / kTwoPi, term.decay});
    }
    return fit;
  }

  double unexplained(const Model& model) const { return std::sqrt(model.left / spread_); }

 private:
  double value_at(const Model& model, double t) const {
    double sum = model.offset;
    for (const Term& term : model.terms)
      sum +=
          std::exp(-term.decay * t) * (term.a * std::cos(term.omega * t) + term.b * std::sin(term.omega * t));
    return sum;
  }

  std::vector<double> left_over(const Model& model) const {
    std::vector<double> rest;
    for (std::size_t k = 0; k < time_.size(); ++k) rest.push_back(value_[k] - value_at(model, time_[k]));
    return rest;
  }

  double sum_of_squares(const Model& model) const {
    double sum = 0.0;
    for (const double r : left_over(model)) sum += r * r;
    return std::isfinite(sum) ? sum : std::numeric_limits<double>::infinity();
  }

  /// How much of `rest` one more term explains.
  double gain_of(const Term& term, const std::vector<double>& rest) const {
    double cc = 0.0;
    double cs = 0.0;
    double ss = 0.0;
    double rc = 0.0;
    double rs = 0.0;
    for (std::size_t k = 0; k < time_.size(); ++k) {
      const double size = std::exp(-term.decay * time_[k]);
      const double c = size * std::cos(term.omega * time_[k]);
      const double s = size * std::sin(term.omega * time_[k]);
      cc += c * c;
      cs += c * s;
      ss += s * s;
      rc += rest[k] * c;
      rs += rest[k] * s;
    }
    const double determinant = cc * ss - cs * cs;
    if (!(determinant > 1e-12 * cc * ss)) return 0.0;
    return (rc * rc * ss - 2.0 * rc * rs * cs + rs * rs * cc) / determinant;
  }

  /// The derivatives of the model at t: by the offset, then by a, b, omega and decay of each term.
  static std::vector<double> slopes(const Model& model, double t, bool linear_alone) {
    std::vector<double> row{1.0};
    for (const Term& term : model.terms) {
      const double size = std::exp(-term.decay * t);
      const double c = size * std::cos(term.omega * t);
      const double s = size * std::sin(term.omega * t);
      row.insert(row.end(), {c, s});
      if (!linear_alone)
        row.insert(row.end(), {t * (term.b * c - term.a * s), -t * (term.a * c + term.b * s)});
    }
    return row;
  }

  /// The change that least squares ask for, with `damping` times the diagonal added.
  std::optional<std::vector<double>> change(const Model& model, bool linear_alone, double damping) const {
    const std::vector<double> rest = left_over(model);
    const std::size_t n = 1 + (linear_alone ? 2 : 4) * model.terms.size();
    std::vector<std::vector<double>> normal(n, std::vector<double>(n, 0.0));
    std::vector<double> right(n, 0.0);
    for (std::size_t k = 0; k < time_.size(); ++k) {
      const std::vector<double> row = slopes(model, time_[k], linear_alone);
      for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = 0; j < n; ++j) normal[i][j] += row[i] * row[j];
        right[i] += row[i] * rest[k];
      }
    }
    for (std::size_t i = 0; i < n; ++i) normal[i][i] *= 1.0 + damping;
    return solve(std::move(normal), std::move(right));
  }

  void set_linear(Model& model) const {
    model.offset = 0.0;
    for (Term& term : model.terms) term.a = term.b = 0.0;
    const auto found = change(model, true, 1e-12);
    if (!found) return;
    model.offset = (*found)[0];
    for (std::size_t k = 0; k < model.terms.size(); ++k) {
      model.terms[k].a = (*found)[1 + 2 * k];
      model.terms[k].b = (*found)[2 + 2 * k];
    }
  }

  Model step(const Model& model, double damping) const {
    Model next = model;
    next.left = std::numeric_limits<double>::infinity();
    const auto found = change(model, false, damping);
    if (!found) return next;
    next.offset += (*found)[0];
    for (std::size_t k = 0; k < next.terms.size(); ++k) {
      next.terms[k].a += (*found)[1 + 4 * k];
      next.terms[k].b += (*found)[2 + 4 * k];
      next.terms[k].omega += (*found)[3 + 4 * k];
      next.terms[k].decay += (*found)[4 + 4 * k];
    }
    next.left = sum_of_squares(next);
    return next;
  }

  std::vector<double> time_;
  std::vector<double> value_;
  double mean_ = 0.0;
  double spread_ = 0.0;
};

/// The order by frequency, as places.
std::vector<std::size_t> places_by_frequency(const std::vector<Oscillation>& oscillations) {
  std::vector<std::size_t> places(oscillations.size());
  for (std::size_t k = 0; k < places.size(); ++k) places[k] = k;
  std::stable_sort(places.begin(), places.end(), [&](std::size_t a, std::size_t b) {
    return oscillations[a].frequency_hz < oscillations[b].frequency_hz;
  });
  return places;
}

/// Puts the lowest where the lowest of `like` stands, and so on: a fit may have found them in another order.
void order_like(const std::vector<Oscillation>& like, std::vector<Oscillation>& found) {
  const std::vector<std::size_t> to = places_by_frequency(like);
  const std::vector<std::size_t> from = places_by_frequency(found);
  const std::vector<Oscillation> before = found;
  for (std::size_t k = 0; k < to.size(); ++k) found[to[k]] = before[from[k]];
}

}  // namespace

std::optional<OscillationFit> fit_oscillations(std::span<const double> time_s, std::span<const double> value,
                                               const FitWindow& window, std::size_t most) {
  constexpr double kEnough = 0.02;
  require(time_s.size() == value.size() && most > 0, "one value a time, and at least one oscillation");
  const Fitting fitting(time_s, value, window);
  if (fitting.is_empty()) return std::nullopt;
  Model model = fitting.add_term({});
  while (model.terms.size() < most && fitting.unexplained(model) > kEnough) {
    Model more = fitting.add_term(model);
    if (!(more.left < model.left)) break;
    model = std::move(more);
  }
  OscillationFit fit = fitting.describe(model);
  const auto strength = [&](const Oscillation& o) {
    const double x = 2.0 * o.decay_per_s * (window.to_s - window.from_s);
    return o.amplitude * o.amplitude * (std::fabs(x) < 1e-6 ? 1.0 : -std::expm1(-x) / x);
  };
  std::stable_sort(fit.oscillations.begin(), fit.oscillations.end(),
                   [&](const Oscillation& a, const Oscillation& b) { return strength(a) > strength(b); });
  return fit;
}

std::optional<OscillationFit> fit_oscillations_like(std::span<const double> time_s,
                                                    std::span<const double> value, const FitWindow& window,
                                                    const OscillationFit& like) {
  require(time_s.size() == value.size(), "one value a time");
  const Fitting fitting(time_s, value, window);
  if (fitting.is_empty()) return std::nullopt;
  Model best;
  for (const double factor : {1.0, 0.94, 1.06, 0.87, 1.14, 0.8, 1.25}) {
    Model start;
    for (const Oscillation& each : like.oscillations)
      start.terms.push_back({0.0, 0.0, factor * kTwoPi * each.frequency_hz, each.decay_per_s});
    Model found = fitting.refine(std::move(start));
    if (found.left < best.left) best = std::move(found);
  }
  if (best.terms.empty()) return std::nullopt;
  OscillationFit fit = fitting.describe(best);
  order_like(like.oscillations, fit.oscillations);
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

}  // namespace palpate::judge

#include "core/judge/motion/oscillation.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <numeric>
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

/// exp((-decay + i omega) t) at all samples, for one omega after the other.
class FrequencyScan {
 public:
  FrequencyScan(const std::vector<double>& time, double decay, double first, double stride) {
    for (const double t : time) {
      at_.push_back(std::polar(std::exp(-decay * t), first * t));
      turn_.push_back(std::polar(1.0, stride * t));
    }
  }

  void advance() {
    for (std::size_t k = 0; k < at_.size(); ++k) {
      const double re = at_[k].real() * turn_[k].real() - at_[k].imag() * turn_[k].imag();
      const double im = at_[k].real() * turn_[k].imag() + at_[k].imag() * turn_[k].real();
      at_[k] = {re, im};
    }
  }

  /// How much of `rest` a term of this omega explains.
  double gain(const std::vector<double>& rest) const {
    double cc = 0.0;
    double cs = 0.0;
    double ss = 0.0;
    double rc = 0.0;
    double rs = 0.0;
    for (std::size_t k = 0; k < at_.size(); ++k) {
      const double c = at_[k].real();
      const double s = at_[k].imag();
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

 private:
  std::vector<std::complex<double>> at_;
  std::vector<std::complex<double>> turn_;
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
    const double low = 0.5 * bin;
    const double high = 0.5 * bin * static_cast<double>(time_.size() - 1);  // two samples a period
    const double stride = 0.2 * bin;  // a fifth of what the window tells apart
    const std::vector<double> rest = left_over(model);
    Term best;
    double most = -1.0;
    const auto count = static_cast<int>((high - low) / stride) + 1;
    for (const double decay : {0.0, 3.0 / time_.back()}) {
      FrequencyScan scan(time_, decay, low, stride);
      for (int k = 0; k < count; ++k, scan.advance()) {
        const double gain = scan.gain(rest);
        if (gain > most) std::tie(most, best) = std::pair{gain, Term{0.0, 0.0, low + stride * k, decay}};
      }
    }
    Model more = model;
    more.terms.push_back(best);
    return refine(std::move(more));
  }

  /// Terms of a scan until enough is explained, or there are `most`.
  Model scan_terms(std::size_t most) const {
    constexpr double kEnough = 0.02;
    Model model = add_term({});
    while (model.terms.size() < most && unexplained(model) > kEnough) {
      Model more = add_term(model);
      if (!(more.left < model.left)) break;
      model = std::move(more);
    }
    return model;
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

/// Mean square over a window of that length, but for a factor.
double strength(const Oscillation& o, double length_s) {
  const double x = 2.0 * o.decay_per_s * length_s;
  return o.amplitude * o.amplitude * (std::fabs(x) < 1e-6 ? 1.0 : -std::expm1(-x) / x);
}

/// What pairing `found` with `like` costs: the sum of how many times as high and as strong the one is.
double pairing_cost(const Oscillation& like, const Oscillation& found, double length_s) {
  constexpr double kFarthest = 20.0;  // also where one of them has no frequency or no strength
  const auto ratio = [](double a, double b) {
    const double log = std::fabs(std::log(a / b));
    return std::isfinite(log) && log < kFarthest ? log : kFarthest;
  };
  return ratio(found.frequency_hz, like.frequency_hz) +
         0.5 * ratio(strength(found, length_s), strength(like, length_s));
}

/// Puts each where its partner in `like` stands. As many places as `like` has, and no more found.
std::vector<Oscillation> pair_with(const std::vector<Oscillation>& like,
                                   const std::vector<Oscillation>& found, double length_s) {
  std::vector<std::size_t> partner(like.size());  // of each of `like`; beyond the found ones: none
  std::iota(partner.begin(), partner.end(), std::size_t{0});
  std::vector<std::size_t> best = partner;
  double least = std::numeric_limits<double>::infinity();
  do {
    if (partner[0] >= found.size()) continue;
    double cost = 0.0;
    for (std::size_t k = 0; k < like.size(); ++k) {
      if (partner[k] < found.size()) cost += pairing_cost(like[k], found[partner[k]], length_s);
    }
    if (cost < least) std::tie(least, best) = std::pair{cost, partner};
  } while (std::next_permutation(partner.begin(), partner.end()));
  std::vector<Oscillation> paired;
  for (std::size_t k = 0; k < like.size(); ++k) {
    paired.push_back(best[k] < found.size()
                         ? found[best[k]]
                         : Oscillation{0.0, 0.0, like[k].frequency_hz, like[k].decay_per_s});
  }
  return paired;
}

}  // namespace

std::optional<OscillationFit> fit_oscillations(std::span<const double> time_s, std::span<const double> value,
                                               const FitWindow& window, std::size_t most) {
  require(time_s.size() == value.size() && most > 0, "one value a time, and at least one oscillation");
  const Fitting fitting(time_s, value, window);
  if (fitting.is_empty()) return std::nullopt;
  OscillationFit fit = fitting.describe(fitting.scan_terms(most));
  const double length_s = window.to_s - window.from_s;
  std::stable_sort(fit.oscillations.begin(), fit.oscillations.end(),
                   [&](const Oscillation& a, const Oscillation& b) {
                     return strength(a, length_s) > strength(b, length_s);
                   });
  return fit;
}

std::optional<OscillationFit> fit_oscillations_like(std::span<const double> time_s,
                                                    std::span<const double> value, const FitWindow& window,
                                                    const OscillationFit& like) {
  constexpr std::size_t kMostPaired = 6;
  require(
      time_s.size() == value.size() && !like.oscillations.empty() && like.oscillations.size() <= kMostPaired,
      "one value a time, and one to six oscillations");
  const Fitting fitting(time_s, value, window);
  if (fitting.is_empty()) return std::nullopt;
  Model best = fitting.scan_terms(like.oscillations.size());
  for (const double factor : {1.0, 0.94, 1.06, 0.87, 1.14, 0.8, 1.25}) {
    Model start;
    for (const Oscillation& each : like.oscillations)
      start.terms.push_back({0.0, 0.0, factor * kTwoPi * each.frequency_hz, each.decay_per_s});
    Model found = fitting.refine(std::move(start));
    if (found.left < best.left) best = std::move(found);
  }
  OscillationFit fit = fitting.describe(best);
  fit.oscillations = pair_with(like.oscillations, fit.oscillations, window.to_s - window.from_s);
  return fit;
}

bool explains_too_little(const OscillationFit& fit) {
  constexpr double kMostUnexplained = 0.2;
  return !(fit.unexplained <= kMostUnexplained);
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

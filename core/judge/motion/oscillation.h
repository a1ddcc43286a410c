// The oscillations of a signal, fitted, and how far those of one signal are from those of another.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace palpate::judge {

/// amplitude exp(-decay (t - from)) cos(2 pi frequency (t - from) + phase).
struct Oscillation {
  double amplitude = 0.0;  ///< at the start of the window, >= 0
  double phase_rad = 0.0;
  double frequency_hz = 0.0;
  double decay_per_s = 0.0;
};

/// A constant and a sum of oscillations, the strongest first: that with the largest mean square of its
/// amplitude over the window.
struct OscillationFit {
  double offset = 0.0;
  std::vector<Oscillation> oscillations;
  double unexplained = 0.0;  ///< sqrt(sum (x - fit)^2 / sum (x - mean)^2) over the window's samples
};

/// Where a signal is fitted: the samples with from <= time <= to.
struct FitWindow {
  double from_s = 0.0;
  double to_s = 0.0;
};

/// Fits at most `most` oscillations to the samples in the window by least squares: each is found by a scan
/// over all frequencies that window and samples can tell apart, from half a period in the window to two
/// samples a period, in what the others leave over; all are then refined together by the method of Levenberg
/// and Marquardt. No more are added once less than 2% of the signal is unexplained.
///
/// Returns: nothing for fewer than 8 samples in the window, or a signal that doesn't change there.
std::optional<OscillationFit> fit_oscillations(std::span<const double> time_s, std::span<const double> value,
                                               const FitWindow& window, std::size_t most);

/// Fits at most as many oscillations as `like` has: from a scan of its own, as above, and from where those of
/// `like` are and up to a quarter beside them; what leaves least over counts. The k-th belongs to the k-th of
/// `like` afterwards, by the pairing with the least sum of |ln f / f'| + |ln s / s'| of frequencies and
/// strengths; the first always has its partner, another that has none has the frequency of `like` and no
/// amplitude.
std::optional<OscillationFit> fit_oscillations_like(std::span<const double> time_s,
                                                    std::span<const double> value, const FitWindow& window,
                                                    const OscillationFit& like);

/// Does the fit explain so little that its figures say nothing? More than a fifth unexplained, 4% of the
/// squares: an amplitude or phase may be off by as much.
bool explains_too_little(const OscillationFit& fit);

/// Errors of an oscillation against that of a reference in the same window.
struct OscillationError {
  double amplitude = 0.0;      ///< amplitude / reference's - 1
  double phase_deg = 0.0;      ///< phase - reference's, in (-180, 180]
  double frequency = 0.0;      ///< frequency / reference's - 1
  double damping_ratio = 0.0;  ///< decay / (2 pi frequency) - reference's
  std::optional<double>
      decay;  ///< decay / reference's - 1; nothing if the reference's damping ratio is below 1e-3
};

/// Requires: a reference with an amplitude and a frequency above zero.
OscillationError compare_oscillations(const Oscillation& found, const Oscillation& reference);

}  // namespace palpate::judge

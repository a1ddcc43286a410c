// The border of what holds along an axis, by bisection.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace palpate::experiments {

/// Endings that are not a motion's own: the error was measured and is above the tolerance, or none was.
inline constexpr const char* kPassesTolerance = "error";
inline constexpr const char* kNotMeasured = "not_measured";

/// What was found at one factor.
struct EnvelopeProbe {
  double factor = 1.0;
  std::optional<double> rest_error;       ///< at rest, against the reference; relative
  std::optional<double> reference_error;  ///< the reference's own
  std::optional<double> step_error;       ///< what the step adds to the motion; relative
  std::string ending;                     ///< "", or what ended it: kPassesTolerance, "diverged", ...
  std::string message;                    ///< what there is to say of the ending

  bool holds() const { return ending.empty(); }
  double error() const { return rest_error.value_or(0.0) + step_error.value_or(0.0); }
};

/// The border along an axis.
struct EnvelopeBorder {
  std::vector<EnvelopeProbe> probes;  ///< by rising factor
  std::optional<double> holds_to;     ///< the greatest factor that holds; nothing if 1 does not
  std::optional<double> fails_at;     ///< the least that does not; nothing if the greatest looked at holds
  bool is_complete = true;            ///< false: stopped before the two were within the resolution
};

/// How close the two sides of a border are brought where nothing else is asked for: their ratio.
inline constexpr double kEnvelopeResolution = 1.1;

/// Given what is found at 1, looks at `most`, then halves the logarithm between the greatest factor that
/// holds and the least that does not, until their ratio is at most `resolution`. It takes for granted that
/// there is one border: all probes are kept, so that another one can be seen. `probe` gives nothing where it
/// was stopped: then the border stays as wide as it is. Requires: most > 1, resolution > 1.
EnvelopeBorder find_border(const EnvelopeProbe& at_one, double most,
                           const std::function<std::optional<EnvelopeProbe>(double)>& probe,
                           double resolution = kEnvelopeResolution);

}  // namespace palpate::experiments

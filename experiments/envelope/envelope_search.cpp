#include "experiments/envelope/envelope_search.h"

#include <algorithm>
#include <cmath>

namespace palpate::experiments {

EnvelopeBorder find_border(const EnvelopeProbe& at_one, double most,
                           const std::function<std::optional<EnvelopeProbe>(double)>& probe,
                           double resolution) {
  EnvelopeBorder border;
  const auto look = [&](const EnvelopeProbe& found) {
    border.probes.push_back(found);
    if (found.holds()) {
      border.holds_to = std::max(border.holds_to.value_or(0.0), found.factor);
    } else {
      border.fails_at = std::min(border.fails_at.value_or(found.factor), found.factor);
    }
  };
  look(at_one);
  double next = most;
  while (border.holds_to) {
    if (border.holds_to >= most) break;
    if (border.fails_at && *border.fails_at / *border.holds_to <= resolution) break;
    const std::optional<EnvelopeProbe> found = probe(next);
    if (!found) {
      border.is_complete = false;
      break;
    }
    look(*found);
    if (border.fails_at) next = std::sqrt(*border.holds_to * *border.fails_at);
  }
  std::sort(border.probes.begin(), border.probes.end(),
            [](const EnvelopeProbe& a, const EnvelopeProbe& b) { return a.factor < b.factor; });
  return border;
}

}  // namespace palpate::experiments

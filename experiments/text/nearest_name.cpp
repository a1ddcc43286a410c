#include "experiments/text/nearest_name.h"

#include <algorithm>

namespace palpate::experiments {

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before_last(b.size() + 1);
  std::vector<std::size_t> last(b.size() + 1);
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, replaced});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) row[j] = std::min(row[j], before_last[j - 2] + 1);
    }
    before_last.swap(last);
    last.swap(row);
  }
  return last[b.size()];
}

std::string nearest_hint(std::string_view name, std::span<const std::string> known) {
  if (known.empty()) return "; none is known";
  const std::string_view start = name.substr(0, 64);
  const auto nearest = std::min_element(known.begin(), known.end(), [&](const auto& a, const auto& b) {
    return edit_distance(start, a) < edit_distance(start, b);
  });
  const std::size_t allowed = std::max<std::size_t>(2, nearest->size() / 3);
  if (nearest->size() > allowed && edit_distance(start, *nearest) <= allowed) {
    return "; did you mean \"" + *nearest + "\"?";
  }
  // A method without its family ("hierarchical" for "palpate.hierarchical").
  const auto part = std::find_if(known.begin(), known.end(), [&](const std::string& k) {
    return start.size() >= 3 && k.find(start) != std::string::npos;
  });
  if (part != known.end()) return "; did you mean \"" + *part + "\"?";
  constexpr std::size_t kMostShown = 12;
  if (known.size() <= kMostShown) return "; known are " + joined(known);
  return "; known are " + joined(known.first(kMostShown)) + " and " +
         std::to_string(known.size() - kMostShown) + " more";
}

std::string joined(std::span<const std::string> names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

}  // namespace palpate::experiments

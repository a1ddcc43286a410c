// "Did you mean": the known name that is nearest to a mistyped one.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace palpate::experiments {

/// Edit distance that counts an insertion, a deletion, a replacement and a swap of neighbours as one each.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The end of a message about an unknown name: `; did you mean "x"?` when one of `known` is near, otherwise
/// the list of them: `; known are a, b, c`.
std::string nearest_hint(std::string_view name, std::span<const std::string> known);

/// The names of what has one.
template <typename Named>
std::vector<std::string> names_of(const std::vector<Named>& all) {
  std::vector<std::string> names;
  names.reserve(all.size());
  for (const Named& each : all) names.push_back(each.name);
  return names;
}

/// The names joined with commas: "a, b, c".
std::string joined(std::span<const std::string> names);

}  // namespace palpate::experiments

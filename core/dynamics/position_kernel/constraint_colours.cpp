#include "core/dynamics/position_kernel/constraint_colours.h"

#include <cstdint>

#include "core/base/error.h"

namespace palpate::dynamics {
namespace {

constexpr std::size_t kWordColours = 64;

/// The colours that a vertex has, a bit each.
using ColourSet = std::vector<std::uint64_t>;

bool has_colour(const ColourSet& set, std::size_t colour) {
  const std::size_t word = colour / kWordColours;
  return word < set.size() && ((set[word] >> (colour % kWordColours)) & 1U) != 0;
}

void add_colour(ColourSet& set, std::size_t colour) {
  const std::size_t word = colour / kWordColours;
  if (word >= set.size()) set.resize(word + 1);
  set[word] |= std::uint64_t{1} << (colour % kWordColours);
}

}  // namespace

std::vector<std::vector<Index>> build_colours(const ConstraintVertices& constraints,
                                              std::size_t vertex_count) {
  std::vector<std::vector<Index>> colours;
  std::vector<ColourSet> taken(vertex_count);
  ColourSet seen;
  for (std::size_t c = 0; c < constraints.size(); ++c) {
    seen.clear();
    for (const Index v : constraints.of(c)) {
      const ColourSet& of_vertex = taken[v];
      if (seen.size() < of_vertex.size()) seen.resize(of_vertex.size());
      for (std::size_t word = 0; word < of_vertex.size(); ++word) seen[word] |= of_vertex[word];
    }
    std::size_t colour = 0;
    while (has_colour(seen, colour)) ++colour;
    for (const Index v : constraints.of(c)) add_colour(taken[v], colour);
    if (colour == colours.size()) colours.emplace_back();
    colours[colour].push_back(static_cast<Index>(c));
  }
  return colours;
}

void validate_colours(const ConstraintVertices& constraints, std::size_t vertex_count,
                      std::span<const std::vector<Index>> colours) {
  std::vector<std::uint8_t> is_there(constraints.size());
  std::vector<std::size_t> last(vertex_count);  // 1 + the colour that the vertex had last
  for (std::size_t colour = 0; colour < colours.size(); ++colour) {
    for (const Index c : colours[colour]) {
      require(c < constraints.size() && is_there[c] == 0, "each constraint in one colour");
      is_there[c] = 1;
      for (const Index v : constraints.of(c)) {
        require(last[v] != colour + 1, "no vertex twice in a colour of constraints");
        last[v] = colour + 1;
      }
    }
  }
  for (const std::uint8_t each : is_there) require(each != 0, "each constraint in one colour");
}

}  // namespace palpate::dynamics

// Colours of constraints: those of one colour share no vertex, so that they can be solved at once.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/base/types.h"

namespace palpate::dynamics {

/// The vertices of constraints, one behind the other: those of constraint c are from vertices[offsets[c]]
/// up to, not including, vertices[offsets[c + 1]].
struct ConstraintVertices {
  std::vector<Index> offsets{0};
  std::vector<Index> vertices;

  std::size_t size() const { return offsets.size() - 1; }
  std::span<const Index> of(std::size_t constraint) const {
    return {vertices.data() + offsets[constraint], vertices.data() + offsets[constraint + 1]};
  }
  void add(std::span<const Index> more) {
    vertices.insert(vertices.end(), more.begin(), more.end());
    offsets.push_back(static_cast<Index>(vertices.size()));
  }
};

/// The colours' constraints, in the order of the model. Each constraint, in that order, gets the first colour
/// that none of its vertices has yet: the same on every machine.
///
/// Requires: vertices below `vertex_count`.
std::vector<std::vector<Index>> build_colours(const ConstraintVertices& constraints,
                                              std::size_t vertex_count);

/// Throws: ContractError where two constraints of a colour share a vertex, or a constraint is not in exactly
/// one colour.
void validate_colours(const ConstraintVertices& constraints, std::size_t vertex_count,
                      std::span<const std::vector<Index>> colours);

}  // namespace palpate::dynamics

// What acts on each vertex of a body: springs, domains, faces of supports.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/dynamics/motion/motion_model.h"

namespace palpate::dynamics {

/// Lists of numbers, one a vertex, in compressed rows.
struct VertexLists {
  std::vector<std::size_t> offsets;
  std::vector<Index> items;

  std::span<const Index> of(std::size_t vertex) const {
    return {items.data() + offsets[vertex], items.data() + offsets[vertex + 1]};
  }
};

/// The entries k of `vertex_of`, sorted by the vertex that they hold; those of a vertex in rising order.
VertexLists list_by_vertex(std::size_t vertices, std::span<const Index> vertex_of);

/// A face of a support with what belongs to its group of loads.
struct TimedSupport {
  SupportFace face;
  std::size_t group = 0;
};

/// The supports of all groups of loads, in order.
std::vector<TimedSupport> list_supports(const MotionModel& model);

}  // namespace palpate::dynamics

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

/// At each vertex 2 s for each spring s that starts there, 2 s + 1 for each that ends there.
VertexLists list_spring_ends(const MotionModel& model);

/// The domain of each entry of an operator.
std::vector<Index> list_domains(const StrainOperator& op);

/// A face of a support with what belongs to its group of loads.
struct TimedSupport {
  SupportFace face;
  std::size_t group = 0;
};

/// The supports of all groups of loads, in order.
std::vector<TimedSupport> list_supports(const MotionModel& model);

}  // namespace palpate::dynamics

#include "core/dynamics/motion/vertex_incidence.h"

namespace palpate::dynamics {

VertexLists list_by_vertex(std::size_t vertices, std::span<const Index> vertex_of) {
  VertexLists out{std::vector<std::size_t>(vertices + 1), std::vector<Index>(vertex_of.size())};
  for (const Index v : vertex_of) ++out.offsets[v + 1];
  for (std::size_t v = 0; v < vertices; ++v) out.offsets[v + 1] += out.offsets[v];
  std::vector<std::size_t> next(out.offsets.begin(), out.offsets.end() - 1);
  for (std::size_t k = 0; k < vertex_of.size(); ++k) out.items[next[vertex_of[k]]++] = static_cast<Index>(k);
  return out;
}

VertexLists list_spring_ends(const MotionModel& model) {
  std::vector<Index> ends;
  ends.reserve(2 * model.elastic.springs.springs.size());
  for (const Edge& spring : model.elastic.springs.springs)
    ends.insert(ends.end(), spring.begin(), spring.end());
  return list_by_vertex(model.elastic.rest.size(), ends);
}

std::vector<Index> list_domains(const StrainOperator& op) {
  std::vector<Index> out(op.vertices.size());
  for (std::size_t s = 0; s < op.domains(); ++s) {
    for (Index k = op.offsets[s]; k < op.offsets[s + 1]; ++k) out[k] = static_cast<Index>(s);
  }
  return out;
}

std::vector<TimedSupport> list_supports(const MotionModel& model) {
  std::vector<TimedSupport> out;
  for (std::size_t g = 0; g < model.loads.size(); ++g) {
    for (const SupportFace& face : model.loads[g].loads.supports) out.push_back({face, g});
  }
  return out;
}

}  // namespace palpate::dynamics

#include "core/dynamics/integrators/vertex_incidence.h"

namespace palpate::dynamics {

VertexLists list_by_vertex(std::size_t vertices, std::span<const Index> vertex_of) {
  VertexLists out{std::vector<std::size_t>(vertices + 1), std::vector<Index>(vertex_of.size())};
  for (const Index v : vertex_of) ++out.offsets[v + 1];
  for (std::size_t v = 0; v < vertices; ++v) out.offsets[v + 1] += out.offsets[v];
  std::vector<std::size_t> next(out.offsets.begin(), out.offsets.end() - 1);
  for (std::size_t k = 0; k < vertex_of.size(); ++k) out.items[next[vertex_of[k]]++] = static_cast<Index>(k);
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

#include "reference/mixed_order/adapted_body.h"

#include <algorithm>
#include <string>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/subdivision/bisection.h"
#include "core/mesh/topology.h"
#include "core/simplify/refined/refined.h"
#include "core/simplify/sizing/triangle_tree.h"

namespace palpate::reference {
namespace {

/// The skin's vertices in the coarse mesh, one entry a vertex of the mesh before; kNoIndex inside. Both have
/// them in the same order and at the same places.
std::vector<Index> match_skins(const TetMesh& mesh, const TetMesh& coarse) {
  const std::vector<std::uint8_t> on_skin = build_boundary_vertex_flags(mesh);
  const std::vector<std::uint8_t> on_coarse = build_boundary_vertex_flags(coarse);
  std::vector<Index> match(mesh.points.size(), kNoIndex);
  Index next = 0;
  for (std::size_t v = 0; v < match.size(); ++v) {
    if (on_skin[v] == 0) continue;
    while (next < coarse.points.size() && on_coarse[next] == 0) ++next;
    require(next < coarse.points.size() && coarse.points[next] == mesh.points[v],
            "the skin stays to the bit");
    match[v] = next++;
  }
  return match;
}

BoundaryProblem renumber(const BoundaryProblem& problem, const std::vector<Index>& match) {
  BoundaryProblem out = problem;
  const auto move = [&](std::vector<Triangle>& faces) {
    for (Triangle& face : faces) {
      for (Index& v : face) v = match[v];
    }
  };
  for (HeldFaces& held : out.held) move(held.faces);
  for (ElasticSupport& support : out.supports) move(support.patch.faces);
  for (Traction& traction : out.tractions) move(traction.patch.faces);
  for (NodalForce& force : out.nodal_forces) {
    if (match[force.vertex] == kNoIndex)
      throw InputError("nodal_forces", 0, "forces on the skin: the inside is coarsened",
                       "one on vertex " + std::to_string(force.vertex));
    force.vertex = match[force.vertex];
  }
  return out;
}

/// Everything that is held, supported or loaded; a point is a triangle without size.
std::vector<Triangle> touched_places(const BoundaryProblem& problem) {
  std::vector<Triangle> places;
  const auto add = [&](const std::vector<Triangle>& faces) {
    places.insert(places.end(), faces.begin(), faces.end());
  };
  for (const HeldFaces& held : problem.held) add(held.faces);
  for (const ElasticSupport& support : problem.supports) add(support.patch.faces);
  for (const Traction& traction : problem.tractions) add(traction.patch.faces);
  for (const NodalForce& force : problem.nodal_forces)
    places.push_back({force.vertex, force.vertex, force.vertex});
  return places;
}

}  // namespace

AdaptedBody adapt_body(const TetMesh& mesh, const BoundaryProblem& problem, const AdaptOptions& options) {
  if (!problem.body_force_n_m3.empty() || !problem.held_field_m.empty())
    throw InputError("problem", 0, "no body force or held displacement that varies, on another mesh", "one");
  AdaptedBody out{mesh, problem, 0};
  if (options.ratio > 0.0) {
    simplify::RefinedOptions refined;
    refined.objective = simplify::Objective::kQuality;
    refined.tools.never_worse = false;
    refined.stop.ratio = options.ratio;
    simplify::simplify_refined(out.mesh, refined);
    out.problem = renumber(problem, match_skins(mesh, out.mesh));
  }
  out.vertices_coarse = out.mesh.points.size();
  const std::vector<Triangle> touched = touched_places(out.problem);
  const std::size_t wanted = std::max(options.vertices, out.vertices_coarse + options.added);
  if (wanted <= out.vertices_coarse || touched.empty()) return out;
  const simplify::TriangleTree tree(out.mesh.points, touched);
  const BoundingBox box = bounding_box(out.mesh.points);
  const double reach_m = options.reach * length(box.high - box.low);
  const auto size = [&](const Vec3& place) {
    const double t = std::min(1.0, tree.distance(place, reach_m) / reach_m);
    return options.near_size + (1.0 - options.near_size) * t * t * (3.0 - 2.0 * t);
  };
  BisectedMesh finer = bisect_edges(out.mesh, wanted, size);
  out.problem = bisect_problem(out.problem, out.vertices_coarse, finer.halved);
  out.mesh = std::move(finer.mesh);
  return out;
}

}  // namespace palpate::reference

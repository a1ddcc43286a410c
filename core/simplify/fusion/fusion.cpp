#include "core/simplify/fusion/fusion.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/space_order.h"

namespace palpate::simplify {
namespace {

/// Room for new rows in meshes too small for a quarter to matter.
constexpr std::size_t kSpareEntries = 1024;

/// Moves all rows to the front of star_tets, in the order in which they stand, so that the tail is free.
void compact_stars(FusionMesh& mesh) {
  std::vector<Index> order(mesh.star_begin.size());
  std::iota(order.begin(), order.end(), Index{0});
  std::sort(order.begin(), order.end(),
            [&](Index a, Index b) { return mesh.star_begin[a] < mesh.star_begin[b]; });
  std::uint64_t end = 0;
  for (const Index v : order) {
    const auto first = mesh.star_tets.begin() + static_cast<std::ptrdiff_t>(mesh.star_begin[v]);
    std::move(first, first + mesh.star_size[v], mesh.star_tets.begin() + static_cast<std::ptrdiff_t>(end));
    mesh.star_begin[v] = mesh.star_size[v] == 0 ? 0 : end;
    mesh.star_capacity[v] = mesh.star_size[v];
    end += mesh.star_size[v];
  }
  mesh.star_tets.resize(end);
}

/// Gives vertex v a row for `size` tets: one of the four old rows if it is large enough, else a new one at
/// the end.
void allocate_row(FusionMesh& mesh, Index v, const Tet& old_vertices, std::size_t size) {
  Index widest = v;
  for (const Index w : old_vertices) {
    if (mesh.star_capacity[w] > mesh.star_capacity[widest]) widest = w;
  }
  if (mesh.star_capacity[widest] >= size) {
    std::swap(mesh.star_begin[v], mesh.star_begin[widest]);
    std::swap(mesh.star_capacity[v], mesh.star_capacity[widest]);
  }
  for (const Index w : old_vertices) {
    mesh.star_size[w] = 0;
    if (w != v) mesh.star_capacity[w] = 0;
  }
  if (mesh.star_capacity[v] < size) {
    if (mesh.star_tets.size() + size > mesh.star_tets.capacity()) {
      compact_stars(mesh);
      const std::size_t live = mesh.star_tets.size();
      if (live + live / 16 + size > mesh.star_tets.capacity()) mesh.star_tets.reserve(live + live / 4 + size);
    }
    mesh.star_begin[v] = mesh.star_tets.size();
    mesh.star_capacity[v] = static_cast<Index>(size);
    mesh.star_tets.resize(mesh.star_tets.size() + size);
  }
  mesh.star_size[v] = static_cast<Index>(size);
}

void erase_from_star(FusionMesh& mesh, Index v, Index tet) {
  Index* const row = mesh.star_tets.data() + mesh.star_begin[v];
  Index* const last = row + mesh.star_size[v];
  Index* const found = std::find(row, last, tet);
  require(found != last, "erase_from_star: the tet is not in the star");
  *found = *(last - 1);
  --mesh.star_size[v];
}

}  // namespace

FusionMesh build_fusion_mesh(TetMesh&& mesh, StorageOrder order, int threads) {
  FusionMesh result;
  if (order == StorageOrder::kSpatial) {
    MeshOrigin origin = sort_in_space(mesh, threads);
    result.vertex_origin = std::move(origin.vertices);
    result.tet_origin = std::move(origin.tets);
  }
  VertexStars stars = build_vertex_stars(mesh, threads);
  const std::size_t vertices = mesh.points.size();
  result.star_begin.resize(vertices);
  result.star_size.resize(vertices);
  result.star_capacity.resize(vertices);
  for (Index v = 0; v < vertices; ++v) {
    result.star_begin[v] = stars.offsets[v];
    result.star_size[v] = result.star_capacity[v] = stars.offsets[v + 1] - stars.offsets[v];
  }
  result.star_tets = std::move(stars.tets);
  result.star_tets.reserve(result.star_tets.size() + result.star_tets.size() / 4 + kSpareEntries);
  result.points = std::move(mesh.points);
  result.tets = std::move(mesh.tets);
  result.alive = result.tets.size();
  mesh = {};
  return result;
}

TetMesh extract_mesh(FusionMesh&& mesh) {
  std::vector<Index>().swap(mesh.star_tets);
  // Input number of each alive tet and used vertex -> storage number, then a walk in the input's order.
  std::vector<Index> storage_of(std::max(mesh.tets.size(), mesh.points.size()), kNoIndex);
  TetMesh result;
  for (Index v = 0; v < mesh.points.size(); ++v) {
    if (mesh.star_size[v] > 0) storage_of[mesh.origin_of_vertex(v)] = v;
  }
  std::vector<Index> new_number(mesh.points.size(), kNoIndex);
  for (std::size_t origin = 0; origin < mesh.points.size(); ++origin) {
    const Index v = storage_of[origin];
    if (v == kNoIndex) continue;
    new_number[v] = static_cast<Index>(result.points.size());
    result.points.push_back(mesh.points[v]);
  }
  std::fill(storage_of.begin(), storage_of.end(), kNoIndex);
  for (Index t = 0; t < mesh.tets.size(); ++t) {
    if (mesh.is_alive(t)) storage_of[mesh.origin_of_tet(t)] = t;
  }
  result.tets.reserve(mesh.alive);
  for (std::size_t origin = 0; origin < mesh.tets.size(); ++origin) {
    const Index t = storage_of[origin];
    if (t == kNoIndex) continue;
    Tet tet = mesh.tets[t];
    for (Index& v : tet) v = new_number[v];
    result.tets.push_back(tet);
  }
  mesh = {};
  return result;
}

std::array<std::size_t, 4> farthest_corners_first(const std::array<Vec3, 4>& corners,
                                                  const Vec3& barycenter) {
  std::array<double, 4> distance_sq;
  for (std::size_t i = 0; i < 4; ++i) distance_sq[i] = length_sq(corners[i] - barycenter);
  std::array<std::size_t, 4> order{0, 1, 2, 3};
  const auto sort_pair = [&](std::size_t i, std::size_t j) {
    if (distance_sq[order[i]] < distance_sq[order[j]]) std::swap(order[i], order[j]);
  };
  sort_pair(0, 1);
  sort_pair(2, 3);
  sort_pair(0, 2);
  sort_pair(1, 3);
  sort_pair(1, 2);
  return order;
}

void plan_fusion(const FusionMesh& mesh, Index target, FusionPlan& plan) {
  walk_fusion(mesh, target, plan, [](const MovedTet&) { return true; });
}

void apply_fusion(FusionMesh& mesh, const FusionPlan& plan) {
  require(plan.target != kNoIndex && mesh.is_alive(plan.target), "apply_fusion: the target is dead");
  const Tet center = mesh.tets[plan.target];
  const Index survivor = *std::min_element(center.begin(), center.end(), [&](Index a, Index b) {
    return mesh.origin_of_vertex(a) < mesh.origin_of_vertex(b);
  });
  for (const Index t : plan.dead) {
    for (const Index v : mesh.tets[t]) {
      if (std::find(center.begin(), center.end(), v) == center.end()) erase_from_star(mesh, v, t);
    }
    mesh.tets[t][0] = kNoIndex;
  }
  mesh.alive -= plan.dead.size();
  mesh.points[survivor] = plan.barycenter;
  allocate_row(mesh, survivor, center, plan.moved.size());
  Index* row = mesh.star_tets.data() + mesh.star_begin[survivor];
  for (const MovedTet& m : plan.moved) {
    mesh.tets[m.tet][m.corner] = survivor;
    *row++ = m.tet;
  }
}

double mean_tet_volume(const TetMesh& mesh) {
  return mesh.tets.empty() ? 0.0 : total_volume(mesh) / static_cast<double>(mesh.tets.size());
}

}  // namespace palpate::simplify

// The edges come in the order of a heap that holds them all, however few are held.
#include "core/simplify/tet_operations/shortest_edges.h"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "core/base/random.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "tests/support/refined_checks.h"

namespace palpate::simplify {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

/// What ShortestEdges stands for: all edges in one heap.
class AllEdges {
 public:
  explicit AllEdges(const WorkingMesh& mesh, const SizingField& field) : mesh_(mesh), heap_(mesh, field) {
    for (const Edge& edge : build_edges({mesh.points, mesh.tets})) enter(edge[0], edge[1]);
  }
  std::optional<WaitingEdge> pop() { return heap_.pop(); }
  void park(const WaitingEdge& edge) { heap_.park(edge); }
  void start_over() { heap_.start_over(); }
  void renew(Index gone, Index survivor) {
    heap_.renew(gone);
    heap_.renew(survivor);
    for (const Index t : mesh_.star(survivor)) {
      for (const Index w : mesh_.tets[t]) {
        if (w != survivor && seen_.insert(w).second) enter(survivor, w);
      }
    }
    seen_.clear();
  }

 private:
  void enter(Index a, Index b) {
    if (mesh_.is_free(a) || mesh_.is_free(b)) heap_.push(a, b);
  }

  const WorkingMesh& mesh_;
  EdgeHeap heap_;
  std::set<Index> seen_;
};

struct Walk {
  std::uint64_t collapses = 0;
  std::uint64_t parked = 0;
};

/// Pops from both until nothing is left, twice; an edge is collapsed, or refused as `random` says.
Walk walk_both(WorkingMesh& mesh, ShortestEdges& some, AllEdges& all, SplitMix64& random) {
  Walk walk;
  VertexMarks marks;
  for (int pass = 0; pass < 2; ++pass) {
    while (true) {
      const std::optional<WaitingEdge> found = some.pop();
      const std::optional<WaitingEdge> wanted = all.pop();
      EXPECT_EQ(found.has_value(), wanted.has_value());
      if (!found || !wanted) break;
      EXPECT_EQ(found->key, wanted->key);
      EXPECT_EQ(std::pair(found->a, found->b), std::pair(wanted->a, wanted->b));
      if (testing::Test::HasFailure()) return walk;
      Index gone = found->a;
      Index survivor = found->b;
      if (!mesh.is_free(gone)) std::swap(gone, survivor);
      if (random.below(3) == 0 || !meets_link_condition(mesh, gone, survivor, marks)) {
        some.park(*found);
        all.park(*wanted);
        ++walk.parked;
        continue;
      }
      apply_collapse(mesh, gone, survivor, 0.5 * (mesh.points[gone] + mesh.points[survivor]));
      some.renew(gone, survivor);
      all.renew(gone, survivor);
      ++walk.collapses;
    }
    some.start_over();
    all.start_over();
  }
  return walk;
}

/// On a cube of 6^3 Kuhn cells, with its inner vertices moved by `jitter`.
void expect_order_of_all(double jitter, const SizingOptions& sizing, std::size_t batch) {
  SCOPED_TRACE(std::to_string(batch) + " " + std::to_string(jitter));
  const TetMesh cube = build_kuhn_cube(6, jitter, 4);
  const SizingField field = sizing.keep.empty() ? SizingField() : SizingField(sizing, cube);
  WorkingMesh mesh = build_working_mesh(TetMesh(cube), field);
  ShortestEdges some(mesh, field, batch);
  AllEdges all(mesh, field);
  SplitMix64 random(batch);
  const Walk walk = walk_both(mesh, some, all, random);
  EXPECT_GT(walk.collapses, 50U);
  EXPECT_GT(walk.parked, 50U);
  expect_consistent(mesh);
}

constexpr std::array<std::size_t, 5> kBatches{1, 7, 25, 100, 100000};

TEST(ShortestEdges, ComeInTheOrderOfAHeapOfAllHoweverFewAreHeld) {
  for (const std::size_t batch : kBatches) {
    expect_order_of_all(0.3, {}, batch);
    expect_order_of_all(0.0, {}, batch);  // most edges are equally long
  }
}

TEST(ShortestEdges, ComeInTheSameOrderWhereSizesAreGraded) {
  SizingOptions sizing;
  sizing.keep.push_back({.kind = KeptRegion::Kind::kSphere, .center = {0.1, 0.1, 0.1}, .radius = 0.05});
  sizing.near_size = 0.2;
  for (const std::size_t batch : kBatches) expect_order_of_all(0.3, sizing, batch);
}

}  // namespace
}  // namespace palpate::simplify

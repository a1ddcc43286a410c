#include "core/dynamics/tet_engine/domain_layout.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "core/dynamics/tet_engine/domain_kernel.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/space_order.h"
#include "tests/support/motion_cases.h"

namespace palpate::dynamics {
namespace {

using namespace testing_support;

struct Laid {
  std::vector<StrainTerm> terms;
  std::vector<Index> place;
  DomainBlocks layout;
};

Laid lay_out(Continuum kind, std::size_t block_vertices) {
  const TetMesh mesh = build_kuhn_cube(6, 0.2, 5);
  Laid out;
  out.terms =
      make_continuum(make_free_body(mesh, 0.0), mesh, kind, StrainLaw::kCorotated).elastic.strain_terms;
  const std::vector<Index> order = order_in_space(mesh.points);
  out.place.resize(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) out.place[order[k]] = static_cast<Index>(k);
  out.layout = build_domain_blocks(out.terms, out.place, block_vertices);
  return out;
}

TEST(DomainLayout, EachDomainIsComputedOnceByTheBlockWithMostOfIt) {
  constexpr std::size_t kBlock = 50;
  for (const Continuum kind : {Continuum::kTets, Continuum::kEdgeNode}) {
    const Laid laid = lay_out(kind, kBlock);
    ASSERT_EQ(laid.layout.blocks.size(), (laid.place.size() + kBlock - 1) / kBlock);
    for (std::size_t t = 0; t < laid.terms.size(); ++t) {
      const StrainOperator& op = laid.terms[t].op;
      std::vector<int> seen(op.domains());
      for (std::size_t b = 0; b < laid.layout.blocks.size(); ++b) {
        for (const DomainClass& each : laid.layout.blocks[b].terms[t]) {
          for (const Index s : each.domains) {
            ++seen[s];
            EXPECT_LE(op.vertices_of(s).size(), each.vertices);
            std::map<std::size_t, int> votes;
            for (const Index v : op.vertices_of(s)) ++votes[laid.place[v] / kBlock];
            for (const auto& [block, count] : votes)
              EXPECT_TRUE(count < votes[b] || (count == votes[b] && block >= b));
          }
        }
      }
      EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), static_cast<std::ptrdiff_t>(op.domains()));
    }
  }
}

TEST(DomainLayout, TheHaloIsWhatDomainsHaveOfOtherBlocks) {
  constexpr std::size_t kBlock = 50;
  const Laid laid = lay_out(Continuum::kEdgeNode, kBlock);
  for (std::size_t b = 0; b < laid.layout.blocks.size(); ++b) {
    const DomainBlock& block = laid.layout.blocks[b];
    std::set<Index> expected;
    for (std::size_t t = 0; t < laid.terms.size(); ++t) {
      for (const DomainClass& each : block.terms[t]) {
        for (const Index s : each.domains) {
          for (const Index v : laid.terms[t].op.vertices_of(s)) {
            if (laid.place[v] / kBlock != b) expected.insert(laid.place[v]);
          }
        }
      }
    }
    EXPECT_EQ(std::vector<Index>(expected.begin(), expected.end()), block.halo);
  }
}

TEST(DomainLayout, GroupsWasteLittle) {
  // Sorted by the number of vertices, eight and eight: places that stay empty are fewer than a tenth.
  const Laid laid = lay_out(Continuum::kEdgeNode, 1000);
  for (std::size_t t = 0; t < laid.terms.size(); ++t) {
    std::size_t places = 0;
    std::size_t used = 0;
    for (const DomainClass& each : laid.layout.blocks[0].terms[t]) {
      places += (each.domains.size() + kGroupDomains - 1) / kGroupDomains * kGroupDomains * each.vertices;
      for (const Index s : each.domains) used += laid.terms[t].op.vertices_of(s).size();
    }
    EXPECT_LT(static_cast<double>(places), 1.1 * static_cast<double>(used)) << t;
  }
}

}  // namespace
}  // namespace palpate::dynamics

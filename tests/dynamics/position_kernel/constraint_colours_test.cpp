// Colours of constraints: no vertex twice in one, whatever the mesh; one that is broken is rejected.
#include "core/dynamics/position_kernel/constraint_colours.h"

#include <gtest/gtest.h>

#include <array>
#include <set>
#include <vector>

#include "core/base/error.h"
#include "core/dynamics/elasticity/strain_operator.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/dynamics_cases.h"

namespace palpate::dynamics {
namespace {

ConstraintVertices edges_of(const TetMesh& mesh) {
  ConstraintVertices out;
  for (const auto& [a, b] : testing_support::make_edge_springs(mesh, 1.0).springs) out.add(std::array{a, b});
  return out;
}

ConstraintVertices domains_of(const TetMesh& mesh, StrainDomain kind) {
  const StrainOperator op = build_strain_operator(mesh, kind);
  ConstraintVertices out;
  for (std::size_t s = 0; s < op.domains(); ++s) out.add(op.vertices_of(s));
  return out;
}

TEST(ConstraintColours, NoTwoOfAColourShareAVertexAndEachHasTheFirstThatItMay) {
  const TetMesh mesh = build_kuhn_cube(4, 0.2, 3);
  const std::size_t n = mesh.points.size();
  for (const ConstraintVertices& all :
       {edges_of(mesh), domains_of(mesh, StrainDomain::kTet), domains_of(mesh, StrainDomain::kEdge),
        domains_of(mesh, StrainDomain::kNode)}) {
    const auto colours = build_colours(all, n);
    std::vector<std::size_t> colour_of(all.size(), colours.size());
    std::size_t count = 0;
    for (std::size_t colour = 0; colour < colours.size(); ++colour) {
      std::set<Index> seen;
      for (std::size_t k = 0; k < colours[colour].size(); ++k) {
        const Index c = colours[colour][k];
        EXPECT_EQ(colour_of[c], colours.size()) << "in one colour alone";
        colour_of[c] = colour;
        ++count;
        if (k > 0) {
          EXPECT_LT(colours[colour][k - 1], c) << "in the order of the model";
        }
        for (const Index v : all.of(c)) EXPECT_TRUE(seen.insert(v).second) << c << ' ' << v;
      }
    }
    EXPECT_EQ(count, all.size());
    // Brute force: each earlier colour is that of an earlier constraint with a vertex in common.
    for (std::size_t c = 0; c < all.size(); ++c) {
      std::set<std::size_t> taken;
      const std::set<Index> own(all.of(c).begin(), all.of(c).end());
      for (std::size_t d = 0; d < c; ++d) {
        for (const Index v : all.of(d)) {
          if (own.count(v) != 0) taken.insert(colour_of[d]);
        }
      }
      for (std::size_t colour = 0; colour < colour_of[c]; ++colour) EXPECT_EQ(taken.count(colour), 1U);
    }
    EXPECT_NO_THROW(validate_colours(all, n, colours));
  }
}

TEST(ConstraintColours, ABrokenColourIsRejected) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 3);
  const std::size_t n = mesh.points.size();
  const ConstraintVertices all = edges_of(mesh);
  const auto right = build_colours(all, n);
  auto merged = right;
  merged[0].insert(merged[0].end(), merged[1].begin(), merged[1].end());
  merged.erase(merged.begin() + 1);
  EXPECT_THROW(validate_colours(all, n, merged), ContractError);
  auto missing = right;
  missing.back().pop_back();
  EXPECT_THROW(validate_colours(all, n, missing), ContractError);
  auto twice = right;
  twice.push_back({right[0][0]});
  EXPECT_THROW(validate_colours(all, n, twice), ContractError);
}

TEST(ConstraintColours, MoreColoursThanAWordHas) {
  ConstraintVertices star;
  for (Index v = 1; v <= 150; ++v) star.add(std::array{Index{0}, v});
  const auto colours = build_colours(star, 151);
  ASSERT_EQ(colours.size(), 150U);
  for (std::size_t k = 0; k < colours.size(); ++k)
    EXPECT_EQ(colours[k], std::vector<Index>{static_cast<Index>(k)});
}

}  // namespace
}  // namespace palpate::dynamics

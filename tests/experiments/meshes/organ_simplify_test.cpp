// The thesis's simplifier on the real organs: the fast one against the naive rescan, and what the thesis
// reports.
#include <gtest/gtest.h>

#include "core/judge/mesh/judge.h"
#include "core/simplify/fusion/hierarchical.h"
#include "experiments/meshes/mesh_source.h"
#include "tests/support/naive_hierarchical.h"

namespace palpate::experiments {
namespace {

TetMesh make(const char* name) {
  return make_shape({.name = name}).mesh;
}

TEST(OrganSimplify, SameBytesAsTheNaiveRescan) {
  for (const char* name : {"kidney", "bean"}) {
    const TetMesh input = make(name);
    for (const bool thesis : {true, false}) {
      simplify::SimplifyOptions options;
      if (!thesis) {
        options.drop = 0.5;
        options.ideal_volume = simplify::IdealVolume::kUpdated;
        options.skip_touched = true;
      }
      TetMesh fast = input;
      TetMesh naive = input;
      const auto report = simplify::simplify_hierarchical(fast, options);
      const auto expected = test_support::simplify_naively(naive, options);
      EXPECT_EQ(report.fusions, expected.fusions) << name;
      EXPECT_EQ(fast, naive) << name;
    }
  }
}

TEST(OrganSimplify, EightySevenFusionsAreWithinReachAndLeaveAValidMesh) {
  for (const char* name : {"kidney", "liver", "bean", "ball"}) {
    const TetMesh input = make(name);
    TetMesh output = input;
    simplify::SimplifyOptions options;
    options.stop.fusions = 87;
    const auto report = simplify::simplify_hierarchical(output, options);
    EXPECT_EQ(report.stop, "fusions") << name;
    const judge::Validity validity = judge::check_validity(output);
    EXPECT_TRUE(validity.is_valid()) << name << ": "
                                     << (validity.findings.empty() ? "" : validity.findings.front());
    const judge::Comparison comparison = judge::compare_with_input(output, input);
    EXPECT_EQ(comparison.boundary_changed_faces, 0U) << name;
    EXPECT_TRUE(comparison.euler_unchanged) << name;
    // The same volume summed over other tets: each sum is compensated, so it is good to a few units in the
    // last place.
    EXPECT_LT(comparison.volume_drift_relative, 1e-13) << name;
  }
}

}  // namespace
}  // namespace palpate::experiments

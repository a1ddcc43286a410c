// The files of a motion, and the replay that is made of them.
#include "reference/elastic_models/motion_files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/small_meshes.h"

namespace palpate::reference {
namespace {

/// A body that comes to rest has energies far below the least normal number before they are nothing.
TEST(MotionFiles, ABodyNextToRestIsReplayed) {
  const TetMesh mesh = testing_support::make_kuhn_block(1, 1, 1);
  MotionProblem problem;
  problem.probes = {1};
  for (const double kinetic_j : {1e-300, 1e-310, 5e-324, 0.0}) {
    MotionFiles files("", problem, mesh);
    const std::vector<Vec3> displacement(mesh.points.size(), Vec3{std::sqrt(kinetic_j), 0.0, 0.0});
    MotionRow row;
    row.kinetic_j = kinetic_j;
    row.displacement_m = displacement;
    files.add_row(row);
    const nlohmann::json replay = describe_replay(files, false);
    const auto& columns = replay.at("columns");
    const auto at = std::find(columns.begin(), columns.end(), "kinetic_j") - columns.begin();
    ASSERT_LT(at, static_cast<std::ptrdiff_t>(columns.size()));
    EXPECT_EQ(replay.at("rows").at(0).at(static_cast<std::size_t>(at)), kinetic_j);
  }
}

}  // namespace
}  // namespace palpate::reference

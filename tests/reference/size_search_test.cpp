// The search for a size against counts that are known in closed form.
#include "reference/simplifier_support/size_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <vector>

#include "core/base/error.h"

namespace palpate::reference {
namespace {

/// A mesher that leaves `tets` tets, without making any shape.
TimedMesh mesh_of(double tets) {
  TimedMesh result;
  result.mesh.tets.resize(static_cast<std::size_t>(std::max(0.0, std::round(tets))));
  result.kernel_s = tets;
  return result;
}

TEST(SizeSearch, CubeLawIsMetAtOnce) {
  int tries = 0;
  const auto mesher = [&](double size) {
    ++tries;
    return mesh_of(1000.0 / (size * size * size));
  };
  for (const double first : {0.1, 0.3, 1.0, 40.0}) {
    tries = 0;
    const FoundSize found = search_size(mesher, first, 8000);
    EXPECT_LE(std::fabs(count_mismatch(found.result.mesh.tets.size(), 8000)), 0.002);
    EXPECT_NEAR(found.size, 0.5, 0.001);
    EXPECT_EQ(found.tries, tries);
    EXPECT_LE(tries, 12) << "from " << first;
    EXPECT_NEAR(found.result.kernel_s, static_cast<double>(found.result.mesh.tets.size()), 0.5)
        << "time and mesh are of the same try";
  }
}

/// A skin that stays: 3000 tets however coarse the inside.
TEST(SizeSearch, FixedSkinAndOtherPowers) {
  for (const double power : {1.0, 2.0, 4.0}) {
    const FoundSize found =
        search_size([&](double size) { return mesh_of(3000.0 + 500.0 * std::pow(size, -power)); }, 2.0, 5000);
    EXPECT_LE(std::fabs(count_mismatch(found.result.mesh.tets.size(), 5000)), 0.005) << power;
  }
}

TEST(SizeSearch, ANoisyCountEndsNear) {
  const auto noisy = [](double size) {
    const double wobble = 1.0 + 0.01 * std::sin(1e4 * size);
    return mesh_of(wobble * 4000.0 / (size * size * size));
  };
  const FoundSize found = search_size(noisy, 1.7, 4000);
  EXPECT_LE(std::fabs(count_mismatch(found.result.mesh.tets.size(), 4000)), 0.005);
}

TEST(SizeSearch, AJumpOverTheTargetGivesTheNearerSide) {
  std::vector<double> sizes;
  const FoundSize found = search_size(
      [&](double size) {
        sizes.push_back(size);
        return mesh_of(size < 0.77 ? 1100.0 : 950.0);
      },
      1.0, 1000);
  EXPECT_EQ(found.result.mesh.tets.size(), 950U);
  EXPECT_LE(sizes.size(), 20U);
}

/// A count that jumps by some percent at every turn.
TEST(SizeSearch, JumpsAreLookedAround) {
  const auto jumpy = [](double size) {
    const double step = std::floor(1000.0 * std::log(size));
    const double wobble = 0.03 * std::sin(12.9898 * step);
    return mesh_of(100000.0 * (1.0 + wobble) * std::exp(-3.0 * step / 1000.0));
  };
  for (const std::uint64_t target : {100000U, 110000U, 130000U, 200000U, 70000U}) {
    const FoundSize found = search_size(jumpy, 1.0, target);
    EXPECT_LE(std::fabs(count_mismatch(found.result.mesh.tets.size(), target)), 0.01) << target;
    EXPECT_LE(found.tries, 20);
  }
}

TEST(SizeSearch, ACountThatDoesNotAnswerEndsEarly) {
  int tries = 0;
  const FoundSize found = search_size(
      [&](double) {
        ++tries;
        return mesh_of(100.0);
      },
      1.0, 10);
  EXPECT_EQ(found.result.mesh.tets.size(), 100U);
  EXPECT_LE(tries, 4);
}

TEST(SizeSearch, SizesThatFailAreLeft) {
  int failed = 0;
  const FoundSize found = search_size(
      [&](double size) {
        if (std::fabs(size - 1.0) < 0.005) {
          ++failed;
          throw std::runtime_error("not at this size");
        }
        return mesh_of(1000.0 / (size * size * size));
      },
      1.0, 1000);
  EXPECT_GE(failed, 1);
  EXPECT_LE(std::fabs(count_mismatch(found.result.mesh.tets.size(), 1000)), 0.05);
}

TEST(SizeSearch, FailuresInARowAreHandedOn) {
  int tries = 0;
  const auto fail = [&](double) -> TimedMesh {
    ++tries;
    throw std::runtime_error("never");
  };
  EXPECT_THROW(search_size(fail, 1.0, 10), std::runtime_error);
  EXPECT_EQ(tries, 3);
  const auto refuse = [](double) -> TimedMesh { throw InputError("not this mesh"); };
  EXPECT_THROW(search_size(refuse, 1.0, 10), InputError);
  EXPECT_THROW(search_size(fail, 0.0, 10), ContractError);
}

}  // namespace
}  // namespace palpate::reference

#include "core/base/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <numeric>
#include <stdexcept>
#include <string>

#include "core/base/random.h"

namespace palpate {
namespace {

TEST(Parallel, RangesMakeTheWholeInOrder) {
  for (const std::size_t count : {0UL, 1UL, 4095UL, 8192UL, 100'003UL}) {
    for (const int threads : {-1, 1, 2, 3, 7}) {
      std::vector<std::atomic<int>> visits(count);
      std::vector<std::size_t> ends(count_ranges(count, threads));
      for_ranges(count, threads, [&](std::size_t first, std::size_t last, std::size_t range) {
        for (std::size_t i = first; i < last; ++i) ++visits[i];
        ends.at(range) = last;
      });
      for (const auto& n : visits) ASSERT_EQ(n, 1);
      EXPECT_TRUE(std::is_sorted(ends.begin(), ends.end()));
      EXPECT_EQ(ends.back(), count);
    }
  }
  EXPECT_EQ(count_ranges(100, 8), 1U);
  EXPECT_EQ(count_ranges(3 * kLeastItemsAThread, 8), 3U);
}

TEST(Parallel, TheFirstRangeThatFailsIsHeard) {
  std::atomic<int> ended = 0;
  try {
    for_ranges(4 * kLeastItemsAThread, 4, [&](std::size_t, std::size_t, std::size_t range) {
      ++ended;
      if (range > 0) throw std::runtime_error(std::to_string(range));
    });
    ADD_FAILURE() << "no exception";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "1");
  }
  EXPECT_EQ(ended, 4);
}

TEST(Parallel, SortsTheSameOnAnyNumberOfThreads) {
  SplitMix64 random(3);
  std::vector<std::uint64_t> items(50'000);
  for (auto& item : items) item = random.next();
  std::vector<std::uint64_t> expected = items;
  std::sort(expected.begin(), expected.end());
  for (const int threads : {1, 2, 3, 5}) {
    std::vector<std::uint64_t> sorted = items;
    sort_on_threads(sorted, threads, std::less<>{});
    EXPECT_EQ(sorted, expected) << threads;
  }
}

}  // namespace
}  // namespace palpate

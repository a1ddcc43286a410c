// Loops over ranges on several threads, for work whose parts don't touch each other: what comes out is the
// same for any number of threads.
#pragma once

#include <algorithm>
#include <cstddef>
#include <exception>
#include <vector>

#include "core/base/threads.h"

namespace palpate {

/// Below so many items a thread costs more than it brings.
inline constexpr std::size_t kLeastItemsAThread = 4096;

/// Number of ranges that for_ranges() makes of `count` items.
inline std::size_t count_ranges(std::size_t count, int threads) {
  const std::size_t most = kHasThreads ? std::max<std::size_t>(1, count / kLeastItemsAThread) : 1;
  return std::min(most, static_cast<std::size_t>(std::max(threads, 1)));
}

/// Calls body(first, last, range) once for each of count_ranges() ranges of nearly equal size that together
/// make [0, count), in order, each on a thread of its own; the last one on the caller's.
/// Throws: what the first range (in order) that fails throws, after all have ended.
template <typename Body>
void for_ranges(std::size_t count, int threads, Body&& body) {
  const std::size_t ranges = count_ranges(count, threads);
  std::vector<std::exception_ptr> errors(ranges);
  const auto run = [&](std::size_t range) {
    try {
      body(count * range / ranges, count * (range + 1) / ranges, range);
    } catch (...) {
      errors[range] = std::current_exception();
    }
  };
  {
    std::vector<Thread> others;
    others.reserve(ranges - 1);
    for (std::size_t range = 0; range + 1 < ranges; ++range) others.emplace_back(run, range);
    run(ranges - 1);
  }
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
}

/// Sorts, with `is_less` a strict order in which no two items are equal: the result is the same for any
/// number of threads.
template <typename Item, typename IsLess>
void sort_on_threads(std::vector<Item>& items, int threads, IsLess is_less) {
  const std::size_t ranges = count_ranges(items.size(), threads);
  const auto at = [&](std::size_t range) {
    return items.begin() + static_cast<std::ptrdiff_t>(items.size() * range / ranges);
  };
  for_ranges(items.size(), threads, [&](std::size_t, std::size_t, std::size_t range) {
    std::sort(at(range), at(range + 1), is_less);
  });
  for (std::size_t range = 1; range < ranges; ++range)
    std::inplace_merge(items.begin(), at(range), at(range + 1), is_less);
}

}  // namespace palpate

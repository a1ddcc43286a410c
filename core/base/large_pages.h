// Memory for large arrays that are walked through again and again: on pages of 2 MB where the system has
// them, so that addresses are found faster.
#pragma once

#include <cstddef>
#include <new>
#include <vector>

namespace palpate {

/// Asks the system to back `bytes` from `start` with large pages. It may refuse: only speed depends on it.
void ask_for_large_pages(void* start, std::size_t bytes);

/// Aligned to a cache line; from 2 MB on to a large page.
template <typename T>
struct LargePageAllocator {
  using value_type = T;

  LargePageAllocator() = default;
  template <typename U>
  explicit LargePageAllocator(const LargePageAllocator<U>&) {}

  static constexpr std::size_t kLargePage = std::size_t{1} << 21U;
  static std::align_val_t alignment(std::size_t n) {
    return std::align_val_t{n * sizeof(T) >= kLargePage ? kLargePage : std::size_t{64}};
  }
  T* allocate(std::size_t n) {
    void* start = ::operator new(n * sizeof(T), alignment(n));
    if (n * sizeof(T) >= kLargePage) ask_for_large_pages(start, n * sizeof(T));
    return static_cast<T*>(start);
  }
  void deallocate(T* start, std::size_t n) { ::operator delete(start, alignment(n)); }
  friend bool operator==(const LargePageAllocator&, const LargePageAllocator&) { return true; }
};

/// A vector on large pages, as far as the system gives them.
template <typename T>
using LargeVector = std::vector<T, LargePageAllocator<T>>;

}  // namespace palpate

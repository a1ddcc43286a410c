#include "core/base/large_pages.h"

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace palpate {

void ask_for_large_pages([[maybe_unused]] void* start, [[maybe_unused]] std::size_t bytes) {
#ifdef __linux__
  madvise(start, bytes, MADV_HUGEPAGE);
#endif
}

}  // namespace palpate

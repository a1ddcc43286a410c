// What the processor that we run on can do.
#pragma once

namespace palpate {

/// Whether this processor, and this build, have AVX2: what sources named *_avx2.cpp need.
inline bool has_avx2() {
#if defined(__x86_64__) && defined(__GNUC__)
  return __builtin_cpu_supports("avx2") != 0;
#else
  return false;
#endif
}

}  // namespace palpate

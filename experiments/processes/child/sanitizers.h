// Whether this build runs under AddressSanitizer (the preset `sanitize`).
#pragma once

namespace palpate::experiments {

/// AddressSanitizer reserves terabytes of address space for its shadow, so no process of such a build can
/// have its own bounded (RLIMIT_AS). What does so asks here, and is compiled in every build.
#ifdef PALPATE_SANITIZED
inline constexpr bool kIsSanitized = true;
#else
inline constexpr bool kIsSanitized = false;
#endif

}  // namespace palpate::experiments

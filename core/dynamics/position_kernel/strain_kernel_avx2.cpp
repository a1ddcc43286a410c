// Eight domains at a time with AVX2. Functions carry their instruction set themselves, so that nothing else
// of the library needs it.
#include "core/base/error.h"
#include "core/dynamics/position_kernel/strain_kernel.h"

#if defined(__x86_64__) && defined(__GNUC__)

#define PALPATE_LANES_TARGET __attribute__((target("avx2")))
#include "core/dynamics/position_kernel/strain_lanes.h"
#include "core/dynamics/tet_engine/eight_avx2.h"

namespace palpate::dynamics {

PALPATE_LANES_TARGET void sweep_strains_avx2(const StrainRun& run, const SweptRows& rows,
                                             const SweepOrder& order) {
  sweep_strains_in_lanes<EightDoubles>(run, rows, order);
}

}  // namespace palpate::dynamics

#else

namespace palpate::dynamics {

void sweep_strains_avx2(const StrainRun&, const SweptRows&, const SweepOrder&) {
  throw ContractError("this build has no AVX2");
}

}  // namespace palpate::dynamics

#endif

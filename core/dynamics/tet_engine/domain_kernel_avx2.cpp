// Eight domains at a time with AVX2. Functions carry their instruction set themselves, so that nothing else
// of the library needs it. No fused multiply-add: the bits have to be those of every other processor.
#include "core/base/error.h"
#include "core/dynamics/tet_engine/domain_kernel.h"

#if defined(__x86_64__) && defined(__GNUC__)

#define PALPATE_LANES_TARGET __attribute__((target("avx2")))
#include "core/dynamics/tet_engine/domain_lanes.h"
#include "core/dynamics/tet_engine/eight_avx2.h"

namespace palpate::dynamics {

PALPATE_LANES_TARGET void add_domain_forces_avx2(const DomainLaw& law, const DomainRun<float>& run,
                                                 const BlockMotion<float>& motion, float* force) {
  add_forces_in_lanes<EightFloats>(law, run, motion, force);
}

PALPATE_LANES_TARGET void add_domain_forces_avx2(const DomainLaw& law, const DomainRun<double>& run,
                                                 const BlockMotion<double>& motion, double* force) {
  add_forces_in_lanes<EightDoubles>(law, run, motion, force);
}

}  // namespace palpate::dynamics

#else

namespace palpate::dynamics {

void add_domain_forces_avx2(const DomainLaw&, const DomainRun<float>&, const BlockMotion<float>&, float*) {
  throw ContractError("this build has no AVX2");
}

void add_domain_forces_avx2(const DomainLaw&, const DomainRun<double>&, const BlockMotion<double>&, double*) {
  throw ContractError("this build has no AVX2");
}

}  // namespace palpate::dynamics

#endif

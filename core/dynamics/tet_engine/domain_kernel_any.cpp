// Eight domains at a time on every processor.
#include "core/dynamics/tet_engine/domain_kernel.h"

#include "core/dynamics/tet_engine/domain_lanes.h"
#include "core/dynamics/tet_engine/eight_any.h"

namespace palpate::dynamics {

template <typename Real>
void add_domain_forces(const DomainLaw& law, const DomainRun<Real>& run, const BlockMotion<Real>& motion,
                       Real* force) {
  add_forces_in_lanes<EightOfAny<Real>>(law, run, motion, force);
}

template void add_domain_forces(const DomainLaw&, const DomainRun<float>&, const BlockMotion<float>&, float*);
template void add_domain_forces(const DomainLaw&, const DomainRun<double>&, const BlockMotion<double>&,
                                double*);

}  // namespace palpate::dynamics

#include "core/dynamics/tet_engine/domain_kernel.h"

namespace palpate::dynamics {

template <typename Real>
void mend_domains(const DomainLaw& law, EightDomains<Real>& domains) {
  const Moduli viscous{law.damping_s * law.moduli.lambda_pa, law.damping_s * law.moduli.mu_pa};
  for (std::size_t k = 0; k < kGroupDomains; ++k) {
    if (!domains.is_off[k]) continue;
    Mat3 h;
    Mat3 rate;
    for (std::size_t i = 0; i < 9; ++i) h.m[i] = domains.h[i][k];
    Mat3 p = stress(law.law, law.moduli, h);
    if (law.damping_s != 0.0) {
      for (std::size_t i = 0; i < 9; ++i) rate.m[i] = domains.rate[i][k];
      p += damping_stress(law.law, viscous, h, rate);
    }
    const double volume = domains.volume[k];
    for (std::size_t i = 0; i < 9; ++i) domains.stress[i][k] = static_cast<Real>(-volume * p.m[i]);
  }
}

template void mend_domains(const DomainLaw&, EightDomains<float>&);
template void mend_domains(const DomainLaw&, EightDomains<double>&);

}  // namespace palpate::dynamics

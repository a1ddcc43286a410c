// Eight domains at a time on every processor.
#include "core/dynamics/position_kernel/strain_kernel.h"
#include "core/dynamics/position_kernel/strain_lanes.h"
#include "core/dynamics/tet_engine/eight_any.h"

namespace palpate::dynamics {

void sweep_strains(const StrainRun& run, const SweptRows& rows, const SweepOrder& order) {
  sweep_strains_in_lanes<EightOfAny<double>>(run, rows, order);
}

void mend_rotations(const std::array<bool, kGroupDomains>& is_off, EightRotations& domains) {
  for (std::size_t lane = 0; lane < kGroupDomains; ++lane) {
    if (!is_off[lane]) continue;
    Mat3 f = kIdentity;
    for (std::size_t i = 0; i < 9; ++i) f.m[i] += domains.h[i][lane];
    const Mat3 apart = f - nearest_rotation(f);
    for (std::size_t i = 0; i < 9; ++i) domains.apart[i][lane] = apart.m[i];
  }
}

}  // namespace palpate::dynamics

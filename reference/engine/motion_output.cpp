#include "reference/engine/motion_output.h"

#include <algorithm>
#include <cmath>

#include "core/dynamics/motion/frozen_part.h"

namespace palpate::reference {

void MotionOutput::add_row(const MotionPhase& phase, dynamics::MotionForces& forces,
                           const dynamics::MotionState& state) {
  const dynamics::MotionEnergy energy = measure_energy(phase.model, state);
  const dynamics::VolumeCount volume = count_volume(phase.model, state);
  MotionRow row{state.time_s,
                energy.kinetic_j,
                energy.elastic_j,
                energy.load_j,
                volume.volume_m3,
                volume.inverted,
                0.0,
                {},
                state.displacement_m};
  for (const Vec3& v : state.velocity_m_s) row.largest_speed_m_s = std::max(row.largest_speed_m_s, length(v));
  if (!files_.tools().empty()) {
    const std::vector<Vec3> pushes = forces.group_forces(state);
    for (const std::size_t tool : files_.tools()) {
      const auto at = std::find(phase.loads.begin(), phase.loads.end(), tool);
      row.tool_n.push_back(
          at == phase.loads.end() ? Vec3{} : pushes[static_cast<std::size_t>(at - phase.loads.begin()) + 1]);
    }
  }
  if (!frozen_.empty()) {
    std::vector<Vec3> force(state.displacement_m.size());
    forces.evaluate(state.displacement_m, state.velocity_m_s, state.time_s, force);
    const double now_n = dynamics::frozen_force(frozen_, force);
    const bool is_known = !std::isnan(max_frozen_force_n_);  // a NaN stays
    if (is_known && !(now_n <= max_frozen_force_n_)) max_frozen_force_n_ = now_n;
  }
  files_.add_row(row);
}

}  // namespace palpate::reference

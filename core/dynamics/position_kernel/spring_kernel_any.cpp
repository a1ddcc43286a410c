// Eight springs at a time on every processor.
#include "core/dynamics/position_kernel/spring_kernel.h"
#include "core/dynamics/position_kernel/spring_lanes.h"
#include "core/dynamics/tet_engine/eight_any.h"

namespace palpate::dynamics {

void sweep_springs(const SpringRun& run, const SweptRows& rows, const SweepOrder& order) {
  sweep_springs_in_lanes<EightOfAny<double>>(run, rows, order);
}

}  // namespace palpate::dynamics

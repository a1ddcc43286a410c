// Springs of XPBD packed by colour.
#pragma once

#include <span>
#include <vector>

#include "core/base/large_pages.h"
#include "core/dynamics/elasticity/elastic_model.h"
#include "core/dynamics/position_kernel/position_rows.h"
#include "core/dynamics/position_kernel/spring_kernel.h"

namespace palpate::dynamics {

/// Springs packed by colour: groups of eight of one colour, padded with springs that do nothing at the row
/// behind the last vertex.
class SpringSweep {
 public:
  SpringSweep() = default;
  /// Of the springs `chosen`, which stay in the order of `colours` (of chosen's places). `damping_n_s_per_m`
  /// has one entry a spring of the model, or none. `model` must outlive this.
  SpringSweep(const ElasticModel& model, std::span<const double> damping_n_s_per_m,
              std::span<const Index> chosen, std::span<const std::vector<Index>> colours);

  /// What depends on the length of the step.
  void prepare(double step_s);
  void sweep(const SweptRows& rows, const SweepOrder& order, bool with_avx2);

 private:
  const ElasticModel* model_ = nullptr;
  std::span<const double> damping_n_s_per_m_;
  LargeVector<SpringGroup> groups_;
  std::vector<Index> spring_of_lane_;  ///< or kNoIndex
};

}  // namespace palpate::dynamics

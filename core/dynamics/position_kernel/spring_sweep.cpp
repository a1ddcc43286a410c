#include "core/dynamics/position_kernel/spring_sweep.h"

namespace palpate::dynamics {

SpringSweep::SpringSweep(const ElasticModel& model, std::span<const double> damping_n_s_per_m,
                         std::span<const Index> chosen, std::span<const std::vector<Index>> colours)
    : model_(&model), damping_n_s_per_m_(damping_n_s_per_m) {
  const auto padding = static_cast<std::uint32_t>(kRowNumbers * model.rest.size());
  for (const std::vector<Index>& colour : colours) {
    for (std::size_t first = 0; first < colour.size(); first += kGroupDomains) {
      SpringGroup& group = groups_.emplace_back();
      group.at.fill(padding);
      for (std::size_t lane = 0; lane < kGroupDomains; ++lane) {
        const bool is_there = first + lane < colour.size();
        const Index s = is_there ? chosen[colour[first + lane]] : kNoIndex;
        spring_of_lane_.push_back(s);
        Vec3 rest{1.0, 0.0, 0.0};
        double length_m = 1.0;
        double mesh_length_m = 1.0;
        if (is_there) {
          const auto [a, b] = model.springs.springs[s];
          group.at[lane] = static_cast<std::uint32_t>(kRowNumbers * a);
          group.at[kGroupDomains + lane] = static_cast<std::uint32_t>(kRowNumbers * b);
          rest = model.rest[b] - model.rest[a];
          mesh_length_m = length(rest);
          length_m = model.springs_are_linear ? 0.0 : model.springs.rest_length_m[s];
          if (model.springs_are_linear) rest = mesh_length_m > 0.0 ? (1.0 / mesh_length_m) * rest : Vec3{};
        }
        group.rest[0][lane] = rest.x;
        group.rest[1][lane] = rest.y;
        group.rest[2][lane] = rest.z;
        group.length_m[lane] = length_m;
        group.preload_m2[lane] = (mesh_length_m - length_m) * (mesh_length_m + length_m);
      }
    }
  }
}

void SpringSweep::prepare(double step_s) {
  for (std::size_t k = 0; k < spring_of_lane_.size(); ++k) {
    const Index s = spring_of_lane_[k];
    if (s == kNoIndex) continue;
    SpringGroup& group = groups_[k / kGroupDomains];
    const std::size_t lane = k % kGroupDomains;
    group.stiffness[lane] = step_s * step_s * model_->springs.stiffness_n_per_m[s];
    group.damping[lane] = damping_n_s_per_m_.empty() ? 0.0 : step_s * damping_n_s_per_m_[s];
  }
}

void SpringSweep::sweep(const SweptRows& rows, const SweepOrder& order, bool with_avx2) {
  const SpringRun run{groups_, model_ != nullptr && model_->springs_are_linear, !damping_n_s_per_m_.empty()};
  if (with_avx2) {
    sweep_springs_avx2(run, rows, order);
  } else {
    sweep_springs(run, rows, order);
  }
}

}  // namespace palpate::dynamics

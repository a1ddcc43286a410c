#include "core/dynamics/spring_engine/plain_loads.h"

#include <algorithm>
#include <map>

#include "core/base/component.h"
#include "core/dynamics/linear_algebra/vertex_field.h"
#include "core/mesh/geometry.h"

namespace palpate::dynamics {
namespace {

bool never_changes(const TimeProfile& profile) {
  return std::all_of(profile.share.begin(), profile.share.end(), [](double share) { return share == 1.0; });
}

/// What the supports of a group do to one vertex: -sum of coefficient x displacement + share x moved.
struct SupportRow {
  std::map<Index, double> coefficient;  ///< by place
  Vec3 moved;
};

/// By place. A face's energy 1/2 c sum of (1 + delta_ij) (u_i - by) . (u_j - by) has the gradient
/// c (u_i + sum of u_j - 4 by) at its vertex i.
std::map<Index, SupportRow> build_support_rows(std::span<const SupportFace> supports,
                                               std::span<const Index> place) {
  std::map<Index, SupportRow> rows;
  for (const SupportFace& support : supports) {
    for (const Index a : support.face) {
      SupportRow& row = rows[place[a]];
      for (const Index b : support.face)
        row.coefficient[place[b]] += support.coefficient_n_per_m * (a == b ? 2.0 : 1.0);
      row.moved = row.moved + (4.0 * support.coefficient_n_per_m) * support.by_m;
    }
  }
  return rows;
}

}  // namespace

PlainLoads::PlainLoads(const MotionModel& model, const PlainPlaces& places)
    : steady_(places.order.size()),
      steady_sum_(model.loads.size()),
      is_held_(places.order.size()),
      blocks_((places.order.size() + places.block_vertices - 1) / places.block_vertices),
      start_(model.loads.size()),
      end_(model.loads.size()),
      group_forces_(model.loads.size()) {
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    blocks_[b].first = b * places.block_vertices;
    blocks_[b].forces.resize(model.loads.size());
  }
  for (std::size_t g = 0; g < model.loads.size(); ++g) {
    const TimedLoads& group = model.loads[g];
    profiles_.push_back(group.profile);
    const bool is_steady = never_changes(group.profile);
    for (std::size_t k = 0; is_steady && k < steady_.size(); ++k) {
      const Vec3& force = group.loads.force_n[places.order[k]];
      steady_[k] = steady_[k] + force;
      steady_sum_[g] = steady_sum_[g] + force;
    }
    add_rows(group, static_cast<std::uint32_t>(g), is_steady, model, places);
  }
  for (Block& block : blocks_)
    std::stable_sort(block.rows.begin(), block.rows.end(),
                     [](const Row& a, const Row& b) { return a.at < b.at; });
  add_held(model, places);
}

void PlainLoads::add_rows(const TimedLoads& group, std::uint32_t number, bool is_steady,
                          const MotionModel& model, const PlainPlaces& places) {
  std::map<Index, SupportRow> rows = build_support_rows(group.loads.supports, places.place);
  for (std::size_t k = 0; !is_steady && k < places.order.size(); ++k) {
    if (length_sq(group.loads.force_n[places.order[k]]) > 0.0) rows[static_cast<Index>(k)];
  }
  for (const auto& [k, support] : rows) {
    Block& block = blocks_[k / places.block_vertices];
    Row row{static_cast<Index>(k - block.first), number, support.moved, {}, entries_.size(), 0};
    if (!is_steady) row.load = row.load + group.loads.force_n[places.order[k]];
    for (const auto& [other, coefficient] : support.coefficient) {
      entries_.push_back({other, coefficient});
      row.pull = row.pull + coefficient * places.home(model.elastic.rest[places.order[other]]);
    }
    row.last = entries_.size();
    block.rows.push_back(row);
  }
}

void PlainLoads::add_held(const MotionModel& model, const PlainPlaces& places) {
  std::vector<int> axes(places.order.size());
  for (const HeldComponent& each : find_held(model)) {
    const Index k = places.place[each.vertex];
    Block& block = blocks_[k / places.block_vertices];
    Held held{static_cast<Index>(k - block.first), each.axis, each.group, 0.0, each.by_m,
              model.mass_kg[each.vertex],          0.0};
    held.rest_m = component(places.home(model.elastic.rest[each.vertex]), each.axis);
    if (!model.environment_damping_n_s_per_m.empty())
      held.drag_n_s_per_m = model.environment_damping_n_s_per_m[each.vertex];
    block.held.push_back(held);
    is_held_[k] = ++axes[k] == 3 ? 1 : 0;
  }
}

void PlainLoads::set_times(double time_s, double end_s) {
  for (std::size_t g = 0; g < profiles_.size(); ++g) {
    start_[g] = value_at(profiles_[g], time_s);
    end_[g] = value_at(profiles_[g], end_s);
  }
}

void PlainLoads::set_pad(std::span<const SupportFace> faces, const PlainPlaces& places,
                         std::span<const Vec3> rest) {
  for (Block& block : blocks_) {
    block.pad.clear();
    block.pad_force = {};
  }
  pad_entries_.clear();
  pad_by_m_ = {};
  pad_force_n_ = {};
  for (const auto& [k, support] : build_support_rows(faces, places.place)) {
    Block& block = blocks_[k / places.block_vertices];
    PadRow row{static_cast<Index>(k - block.first), 0.0, {}, pad_entries_.size(), 0};
    for (const auto& [other, coefficient] : support.coefficient) {
      pad_entries_.push_back({other, coefficient});
      row.total_n_per_m += coefficient;
      row.pull = row.pull + coefficient * places.home(rest[places.order[other]]);
    }
    row.last = pad_entries_.size();
    block.pad.push_back(row);
  }
}

template <typename Real>
void PlainLoads::press_pad(Block& block, const PlainRows<const Real>& x, Real* force) const {
  block.pad_force = {};
  for (const PadRow& row : block.pad) {
    Vec3 f = row.total_n_per_m * pad_by_m_ + row.pull;
    for (std::size_t k = row.first; k < row.last; ++k) {
      const Real* at = x.of(pad_entries_[k].place);
      f = f - pad_entries_[k].coefficient_n_per_m * Vec3{at[0], at[1], at[2]};
    }
    block.pad_force = block.pad_force + f;
    Real* sum = force + std::size_t{4} * row.at;
    sum[0] = static_cast<Real>(sum[0] + f.x);
    sum[1] = static_cast<Real>(sum[1] + f.y);
    sum[2] = static_cast<Real>(sum[2] + f.z);
  }
}

template <typename Real>
void PlainLoads::add_forces(std::size_t b, const PlainRows<const Real>& x, Real* force) {
  Block& block = blocks_[b];
  std::fill(block.forces.begin(), block.forces.end(), Vec3{});
  for (const Row& row : block.rows) {
    Vec3 f = start_[row.group].share * row.load + row.pull;
    for (std::size_t k = row.first; k < row.last; ++k) {
      const Real* at = x.of(entries_[k].place);
      f = f - entries_[k].coefficient_n_per_m * Vec3{at[0], at[1], at[2]};
    }
    block.forces[row.group] = block.forces[row.group] + f;
    Real* sum = force + std::size_t{4} * row.at;
    sum[0] = static_cast<Real>(sum[0] + f.x);
    sum[1] = static_cast<Real>(sum[1] + f.y);
    sum[2] = static_cast<Real>(sum[2] + f.z);
  }
  if (!block.pad.empty()) press_pad(block, x, force);
  for (const Held& held : block.held) {
    const ProfileValue& profile = start_[held.group];
    const double needed =
        held.by_m * (held.mass_kg * profile.acceleration_per_s2 + held.drag_n_s_per_m * profile.rate_per_s);
    component(block.forces[held.group], held.axis) +=
        needed - static_cast<double>(force[std::size_t{4} * held.at + held.axis]);
  }
}

template <typename Real>
void PlainLoads::hold(std::size_t b, const PlainRows<Real>& x, const PlainRows<Real>& v) const {
  const Block& block = blocks_[b];
  for (const Held& held : block.held) {
    const std::size_t k = block.first + held.at;
    x.of(k)[held.axis] = static_cast<Real>(held.rest_m + end_[held.group].share * held.by_m);
    v.of(k)[held.axis] = static_cast<Real>(end_[held.group].rate_per_s * held.by_m);
  }
}

template <typename Real>
void PlainLoads::hold_all(double time_s, const PlainRows<Real>& x, const PlainRows<Real>& v) const {
  for (const Block& block : blocks_) {
    for (const Held& held : block.held) {
      const ProfileValue profile = value_at(profiles_[held.group], time_s);
      const std::size_t k = block.first + held.at;
      x.of(k)[held.axis] = static_cast<Real>(held.rest_m + profile.share * held.by_m);
      v.of(k)[held.axis] = static_cast<Real>(profile.rate_per_s * held.by_m);
    }
  }
}

void PlainLoads::gather() {
  for (std::size_t g = 0; g < group_forces_.size(); ++g) {
    Vec3 sum = steady_sum_[g];
    for (const Block& block : blocks_) sum = sum + block.forces[g];
    group_forces_[g] = sum;
  }
  pad_force_n_ = {};
  for (const Block& block : blocks_) pad_force_n_ = pad_force_n_ + block.pad_force;
}

template void PlainLoads::add_forces(std::size_t, const PlainRows<const float>&, float*);
template void PlainLoads::add_forces(std::size_t, const PlainRows<const double>&, double*);
template void PlainLoads::hold(std::size_t, const PlainRows<float>&, const PlainRows<float>&) const;
template void PlainLoads::hold(std::size_t, const PlainRows<double>&, const PlainRows<double>&) const;
template void PlainLoads::hold_all(double, const PlainRows<float>&, const PlainRows<float>&) const;
template void PlainLoads::hold_all(double, const PlainRows<double>&, const PlainRows<double>&) const;

}  // namespace palpate::dynamics

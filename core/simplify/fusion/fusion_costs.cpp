#include "core/simplify/fusion/fusion_costs.h"

#include <algorithm>
#include <array>
#include <bit>

namespace palpate::simplify {
namespace {

Vec3 barycenter_of(const FusionMesh& mesh, Index t) {
  const Tet& v = mesh.tets[t];
  return 0.25 * (mesh.points[v[0]] + mesh.points[v[1]] + mesh.points[v[2]] + mesh.points[v[3]]);
}

/// Bit k is set if corner k of `tet` is a vertex of `other`.
unsigned shared_corners(const Tet& tet, const Tet& other) {
  return corners_that_are(tet, other[0]) | corners_that_are(tet, other[1]) | corners_that_are(tet, other[2]) |
         corners_that_are(tet, other[3]);
}

bool is_single(unsigned bits) {
  return bits != 0U && (bits & (bits - 1U)) == 0U;
}

}  // namespace

FusionCosts::FusionCosts(const FusionMesh& mesh, const CheapestFirstOptions& options, double ideal_volume)
    : mesh_(mesh),
      metric_(options.common.metric),
      ideal_volume_(ideal_volume),
      drop_(options.common.drop),
      counts_removed_(options.objective == CostObjective::kTotalLoss),
      quality_(mesh.tets.size()),
      lost_(mesh.tets.size(), 0.0),
      removed_(mesh.tets.size(), 0),
      mark_(mesh.tets.size(), Mark::kNone),
      is_in_link_(mesh.points.size(), 0) {
  measure_all();
}

void FusionCosts::measure_all() {
  double sum = 0.0;
  for (std::size_t begin = 0; begin < quality_.size(); begin += TetBatch::kCapacity) {
    const std::size_t end = std::min(quality_.size(), begin + TetBatch::kCapacity);
    batch_.size = 0;
    for (std::size_t t = begin; t < end; ++t) {
      const Tet& v = mesh_.tets[t];
      batch_.add(mesh_.points[v[0]], mesh_.points[v[1]], mesh_.points[v[2]], mesh_.points[v[3]]);
    }
    measure_batch(metric_, ideal_volume_, batch_);
    for (std::size_t t = begin; t < end; ++t) sum += quality_[t] = batch_.quality[t - begin];
  }
  if (!quality_.empty()) mean_quality_ = round_to_grid(sum / static_cast<double>(quality_.size()));
}

void FusionCosts::add_to_batch(Index tet, std::size_t corner, const Vec3& position) {
  const Tet& v = mesh_.tets[tet];
  std::array<const Vec3*, 4> p{&mesh_.points[v[0]], &mesh_.points[v[1]], &mesh_.points[v[2]],
                               &mesh_.points[v[3]]};
  p[corner] = &position;
  batch_.add(*p[0], *p[1], *p[2], *p[3]);
}

Refusal FusionCosts::check(std::size_t in_batch, Index moved) const {
  if (!is_positive(batch_, in_batch)) return Refusal::kFlip;
  return batch_.quality[in_batch] < drop_ * quality_[moved] ? Refusal::kQuality : Refusal::kNone;
}

/// Measures the batch, which holds the moved tets from `first_moved` on.
Weighing FusionCosts::flush_star(std::size_t first_moved) {
  measure_batch(metric_, ideal_volume_, batch_);
  for (std::size_t i = 0; i < batch_.size; ++i) {
    const Index tet = plan_.moved[first_moved + i].tet;
    const Refusal refusal = check(i, tet);
    if (refusal != Refusal::kNone) return {refusal, tet};
    after_.push_back(batch_.quality[i]);
  }
  batch_.size = 0;
  return {};
}

Weighing FusionCosts::weigh(Index t) {
  after_.clear();
  batch_.size = 0;
  Weighing weighing;
  Index star_of = kNoIndex;  // the vertex whose star the batch is from: each is checked before the next
  const auto on_moved = [&](const MovedTet& m) {
    const Index vertex = mesh_.tets[m.tet][m.corner];
    if (batch_.size == TetBatch::kCapacity || (vertex != star_of && batch_.size > 0)) {
      weighing = flush_star(plan_.moved.size() - 1 - batch_.size);
      if (weighing.refusal != Refusal::kNone) return false;
    }
    star_of = vertex;
    add_to_batch(m.tet, m.corner, plan_.barycenter);
    return true;
  };
  if (!walk_fusion(mesh_, t, plan_, on_moved)) return weighing;
  if (batch_.size > 0) weighing = flush_star(plan_.moved.size() - batch_.size);
  if (weighing.refusal != Refusal::kNone) return weighing;
  double lost = 0.0;
  for (std::size_t i = 0; i < plan_.moved.size(); ++i) lost += quality_[plan_.moved[i].tet] - after_[i];
  if (counts_removed_) {
    for (const Index dead : plan_.dead) lost += quality_[dead] - mean_quality_;
  }
  lost_[t] = lost;
  removed_[t] = static_cast<std::uint32_t>(plan_.dead.size());
  return weighing;
}

Refusal FusionCosts::check_on(Index t, Index witness) {
  if (!mesh_.is_alive(witness)) return Refusal::kNone;
  const unsigned shared = shared_corners(mesh_.tets[witness], mesh_.tets[t]);
  if (!is_single(shared)) return Refusal::kNone;
  batch_.size = 0;
  add_to_batch(witness, static_cast<std::size_t>(std::countr_zero(shared)), barycenter_of(mesh_, t));
  measure_batch(metric_, ideal_volume_, batch_);
  return check(0, witness);
}

void FusionCosts::mark_changes() {
  affected_.clear();
  link_.clear();
  const Tet& center = mesh_.tets[plan_.target];
  const auto add_link = [&](Index tet) {
    for (const Index v : mesh_.tets[tet]) {
      if (is_in_link_[v] != 0 || corners_that_are(center, v) != 0U) continue;
      is_in_link_[v] = 1;
      link_.push_back(v);
    }
  };
  for (const MovedTet& m : plan_.moved) {
    mark_[m.tet] = Mark::kMoved;
    add_link(m.tet);
  }
  for (const Index t : plan_.dead) {
    mark_[t] = Mark::kDead;
    add_link(t);
  }
}

/// The changed tets around a candidate, each once: at the first corner of the candidate that it shares.
void FusionCosts::find_terms(Index affected) {
  const Index t = affected_[affected].tet;
  const Tet& candidate = mesh_.tets[t];
  for (std::size_t k = 0; k < 4; ++k) {
    if (is_in_link_[candidate[k]] == 0) continue;
    for (const Index other : mesh_.star(candidate[k])) {
      if (mark_[other] != Mark::kMoved && mark_[other] != Mark::kDead) continue;
      const unsigned in_candidate = shared_corners(candidate, mesh_.tets[other]);
      if (std::countr_zero(in_candidate) != static_cast<int>(k)) continue;
      const unsigned in_other = corners_that_are(mesh_.tets[other], candidate[k]);
      const bool is_moved_by_candidate = is_single(in_candidate);
      (is_moved_by_candidate ? terms_ : shared_)
          .push_back({affected, other, static_cast<std::uint8_t>(std::countr_zero(in_other))});
    }
  }
}

void FusionCosts::take_out_old_terms() {
  terms_.clear();
  shared_.clear();
  for (Index n = 0; n < affected_.size(); ++n) {
    affected_[n].barycenter = barycenter_of(mesh_, affected_[n].tet);
    find_terms(n);
  }
  for (const Term& term : shared_) {
    const Index t = affected_[term.affected].tet;
    if (mark_[term.tet] == Mark::kDead) --removed_[t];
    if (counts_removed_) lost_[t] -= quality_[term.tet] - mean_quality_;
  }
  for (std::size_t begin = 0; begin < terms_.size(); begin += TetBatch::kCapacity) {
    const std::size_t end = std::min(terms_.size(), begin + TetBatch::kCapacity);
    batch_.size = 0;
    for (std::size_t n = begin; n < end; ++n) {
      add_to_batch(terms_[n].tet, terms_[n].corner, affected_[terms_[n].affected].barycenter);
    }
    measure_batch(metric_, ideal_volume_, batch_);
    for (std::size_t n = begin; n < end; ++n) {
      lost_[affected_[terms_[n].affected].tet] -= quality_[terms_[n].tet] - batch_.quality[n - begin];
    }
  }
}

void FusionCosts::put_in_new_terms() {
  for (std::size_t i = 0; i < plan_.moved.size(); ++i) quality_[plan_.moved[i].tet] = after_[i];
  const auto is_dead = [this](const Term& term) { return mark_[term.tet] == Mark::kDead; };
  std::erase_if(terms_, is_dead);
  if (counts_removed_) {
    for (const Term& term : shared_) {
      if (!is_dead(term)) lost_[affected_[term.affected].tet] += quality_[term.tet] - mean_quality_;
    }
  }
  for (std::size_t begin = 0; begin < terms_.size(); begin += TetBatch::kCapacity) {
    const std::size_t end = std::min(terms_.size(), begin + TetBatch::kCapacity);
    batch_.size = 0;
    for (std::size_t n = begin; n < end; ++n) {
      add_to_batch(terms_[n].tet, terms_[n].corner, affected_[terms_[n].affected].barycenter);
    }
    measure_batch(metric_, ideal_volume_, batch_);
    for (std::size_t n = begin; n < end; ++n) {
      Affected& affected = affected_[terms_[n].affected];
      const Refusal refusal = check(n - begin, terms_[n].tet);
      if (refusal != Refusal::kNone) affected.weighing = {refusal, terms_[n].tet};
      lost_[affected.tet] += quality_[terms_[n].tet] - batch_.quality[n - begin];
    }
  }
  for (const MovedTet& m : plan_.moved) mark_[m.tet] = Mark::kNone;
  for (const Index t : plan_.dead) mark_[t] = Mark::kNone;
  for (const Affected& a : affected_) mark_[a.tet] = Mark::kNone;
  for (const Index v : link_) is_in_link_[v] = 0;
}

}  // namespace palpate::simplify

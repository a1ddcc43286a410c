// The candidates of one level, worst first, under a fixed or a growing ideal volume.
#pragma once

#include <algorithm>
#include <functional>
#include <span>
#include <vector>

#include "core/base/types.h"
#include "core/simplify/fusion/fusion.h"
#include "core/simplify/fusion/fusion_options.h"
#include "core/simplify/quality/quality.h"

namespace palpate::simplify {

/// A candidate with what orders it; equal keys by the number in the input.
struct Candidate {
  double key;
  Index origin;
  Index tet;

  friend bool operator>(const Candidate& a, const Candidate& b) {
    return a.key != b.key ? a.key > b.key : a.origin > b.origin;
  }
};

/// A binary heap, smallest first, whose entries may be out of date: `is_current` tells, and stale ones are
/// dropped when they come up, or all at once when they outnumber the rest.
class LazyHeap {
 public:
  void clear() { entries_.clear(); }
  void reserve(std::size_t entries) { entries_.reserve(entries); }

  void push(const Candidate& candidate) {
    entries_.push_back(candidate);
    std::push_heap(entries_.begin(), entries_.end(), std::greater<>{});
  }

  /// Adds without order; heapify() has to follow.
  void append(const Candidate& candidate) { entries_.push_back(candidate); }
  void heapify() {
    std::make_heap(entries_.begin(), entries_.end(), std::greater<>{});
    tidy_at_ = std::max<std::size_t>(kSmallestTidy, 2 * entries_.size());
  }

  /// The smallest current entry, or nullptr.
  template <typename IsCurrent>
  const Candidate* top(IsCurrent&& is_current) {
    while (!entries_.empty() && !is_current(entries_.front())) pop();
    return entries_.empty() ? nullptr : &entries_.front();
  }

  void pop() {
    std::pop_heap(entries_.begin(), entries_.end(), std::greater<>{});
    entries_.pop_back();
  }

  /// Drops the stale entries if the heap has grown beyond twice what it held after the last time.
  template <typename IsCurrent>
  void tidy(IsCurrent&& is_current) {
    if (entries_.size() < tidy_at_) return;
    std::erase_if(entries_, [&](const Candidate& c) { return !is_current(c); });
    heapify();
  }

 private:
  static constexpr std::size_t kSmallestTidy = 4096;

  std::vector<Candidate> entries_;
  std::size_t tidy_at_ = kSmallestTidy;
};

/// Where a candidate of the current level stands.
enum class State : std::uint8_t {
  kIdle,           ///< no candidate (yet, or any more)
  kWaiting,        ///< in the queue
  kParkedFlip,     ///< its witness would flip
  kParkedQuality,  ///< its witness would lose too much quality
  kRefusedFlip,    ///< was parked so when its level ended
  kRefusedQuality,
  kTouched,  ///< moved by a fusion, with skip_touched
  kKept      ///< has a vertex that the sizing field keeps
};

/// Whether a candidate waits on its witness.
inline bool is_parked(State s) {
  return s == State::kParkedFlip || s == State::kParkedQuality;
}

/// The qualities of the tets: one key a tet while the ideal volume is fixed, shape and volume when it grows.
class Qualities {
 public:
  Qualities(const FusionMesh& mesh, const SimplifyOptions& options, double ideal_volume)
      : metric_(options.metric),
        is_updated_(options.ideal_volume == IdealVolume::kUpdated && options.metric.has_volume_factor),
        ideal_volume_(ideal_volume),
        value_(mesh.tets.size(), kUnknown) {
    if (is_updated_) volume_.resize(mesh.tets.size());
  }

  /// Measures tet t, positive as the input has it, unless that has been done. Most tets of the outermost
  /// levels are never asked for.
  void ensure(const FusionMesh& mesh, Index t) {
    if (value_[t] != kUnknown) return;
    const Tet& v = mesh.tets[t];
    set(t, measure_positive_tet(metric_, mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]],
                                mesh.points[v[3]]));
  }

  bool is_updated() const { return is_updated_; }
  double ideal_volume() const { return ideal_volume_; }
  void set_ideal_volume(double ideal_volume) { ideal_volume_ = ideal_volume; }

  void set(Index t, const TetFigures& f) {
    value_[t] = is_updated_ ? f.shape : quality_key(metric_, f.shape, f.volume, ideal_volume_);
    if (is_updated_) volume_[t] = f.volume;
  }

  double key(Index t) const {
    return is_updated_ ? quality_key(metric_, value_[t], volume_[t], ideal_volume_) : value_[t];
  }
  double key(const TetFigures& f) const { return quality_key(metric_, f.shape, f.volume, ideal_volume_); }

  double shape(Index t) const { return value_[t]; }    ///< only while is_updated()
  double volume(Index t) const { return volume_[t]; }  ///< only while is_updated()

 private:
  static constexpr double kUnknown = -1.0;

  QualityMetric metric_;
  bool is_updated_;
  double ideal_volume_;
  std::vector<double> value_;
  std::vector<double> volume_;
};

/// The waiting candidates. With a growing ideal volume the keys of all change at once, but in two groups that
/// keep their order: shape * volume below the ideal volume, shape above it; and tets only ever pass from
/// above to below.
class CandidateQueue {
 private:
  auto is_current_small() const {
    return [this](const Candidate& c) {
      if (state_[c.tet] != State::kWaiting) return false;
      if (!qualities_.is_updated()) return c.key == qualities_.key(c.tet);
      return qualities_.volume(c.tet) < qualities_.ideal_volume() &&
             c.key == qualities_.shape(c.tet) * qualities_.volume(c.tet);
    };
  }
  auto is_current_large() const {
    return [this](const Candidate& c) {
      return state_[c.tet] == State::kWaiting && qualities_.volume(c.tet) >= qualities_.ideal_volume() &&
             c.key == qualities_.shape(c.tet);
    };
  }
  auto is_current_crossing() const {
    return [this](const Candidate& c) {
      return state_[c.tet] == State::kWaiting && c.key == qualities_.volume(c.tet);
    };
  }

 public:
  CandidateQueue(const FusionMesh& mesh, const Qualities& qualities, const std::vector<State>& state)
      : mesh_(mesh), qualities_(qualities), state_(state) {}

  /// Starts anew with the given candidates.
  void fill(std::span<const Index> tets) {
    for (LazyHeap* heap : {&small_, &large_, &crossing_}) heap->clear();
    for (const Index t : tets) {
      if (state_[t] == State::kWaiting) place(t, [](LazyHeap& heap, const Candidate& c) { heap.append(c); });
    }
    for (LazyHeap* heap : {&small_, &large_, &crossing_}) heap->heapify();
  }

  void push(Index t) {
    place(t, [](LazyHeap& heap, const Candidate& c) { heap.push(c); });
    small_.tidy(is_current_small());
    large_.tidy(is_current_large());
    crossing_.tidy(is_current_crossing());
  }

  /// Removes and returns the worst candidate, kNoIndex if none waits.
  Index pop_worst() {
    const Candidate* small = nullptr;
    if (qualities_.is_updated()) {
      move_crossed();
      const Candidate large = pop_worst_large();
      small = small_.top(is_current_small());
      if (large.tet != kNoIndex) {
        if (small == nullptr || *small > large) return large.tet;
        large_.push({qualities_.shape(large.tet), large.origin, large.tet});
      }
    } else {
      small = small_.top(is_current_small());
    }
    if (small == nullptr) return kNoIndex;
    const Index worst = small->tet;
    small_.pop();
    return worst;
  }

 private:
  /// Hands t to the heaps where it belongs.
  template <typename Add>
  void place(Index t, Add&& add) {
    const Index origin = mesh_.origin_of_tet(t);
    if (!qualities_.is_updated()) {
      add(small_, Candidate{qualities_.key(t), origin, t});
    } else if (qualities_.volume(t) < qualities_.ideal_volume()) {
      add(small_, Candidate{qualities_.shape(t) * qualities_.volume(t), origin, t});
    } else {
      add(large_, Candidate{qualities_.shape(t), origin, t});
      add(crossing_, Candidate{qualities_.volume(t), origin, t});
    }
  }

  /// Moves the tets that the ideal volume has overtaken from the large ones to the small ones.
  void move_crossed() {
    while (const Candidate* c = crossing_.top(is_current_crossing())) {
      if (c->key >= qualities_.ideal_volume()) return;
      const Index t = c->tet;
      crossing_.pop();
      small_.push({qualities_.shape(t) * qualities_.volume(t), mesh_.origin_of_tet(t), t});
    }
  }

  /// Removes and returns the worst of the large ones with its full key. Shapes that differ may round to one
  /// key, and then the number decides.
  Candidate pop_worst_large() {
    const Candidate* top = large_.top(is_current_large());
    if (top == nullptr) return {0.0, kNoIndex, kNoIndex};
    const double key = top->key * qualities_.ideal_volume();
    same_key_.clear();
    while (top != nullptr && top->key * qualities_.ideal_volume() == key) {
      same_key_.push_back(*top);
      large_.pop();
      top = large_.top(is_current_large());
    }
    const auto worst =
        std::min_element(same_key_.begin(), same_key_.end(),
                         [](const Candidate& a, const Candidate& b) { return a.origin < b.origin; });
    const Candidate result{key, worst->origin, worst->tet};
    for (const Candidate& c : same_key_) {
      if (c.tet != result.tet) large_.push(c);
    }
    return result;
  }

  const FusionMesh& mesh_;
  const Qualities& qualities_;
  const std::vector<State>& state_;
  LazyHeap small_;
  LazyHeap large_;
  LazyHeap crossing_;
  std::vector<Candidate> same_key_;
};

}  // namespace palpate::simplify

#include "core/simplify/refined/repair.h"

#include <algorithm>
#include <array>

namespace palpate::simplify {
namespace {

/// c of gain_of_score in repairs, where few tets are bad and where many are.
constexpr double kGainOffset = 0.003;
constexpr double kGainOffsetOfMany = 0.01;

/// Share of bad tets up to which they are few: 0.7 to 3% on organs with a coarse skin, 21% and more where the
/// skin is as fine as the inside.
constexpr double kFewBad = 0.1;

/// Where many are bad, what helps more seldom is given up.
constexpr std::uint64_t kTriesPerHelp = 10;

/// A round takes at most so many tets, and one in so many of all; with compound moves fewer, and where many
/// are bad fewer still.
constexpr std::size_t kAlwaysRepaired = 32;
constexpr std::size_t kShareOfRepair = 4;
constexpr std::size_t kShareOfCompound = 32;
constexpr std::size_t kShareOfCompoundOfMany = 64;

/// A compound move smooths the vertices around so many times.
constexpr int kSweepsOfCompound = 3;

/// A compound move that makes the worst tet around so many times better is kept whatever the sum says.
constexpr double kWorthAnyway = 2.0;

/// Shifts of a vertex of the ring away from the edge, or towards it, that may make a flip possible.
constexpr std::array kShifts{0.15, 0.3, -0.15, 0.5};

/// Edges are split only for tets below this score: a count is not given away lightly.
constexpr double kSplitThreshold = 0.03;

/// A vertex is inserted only for tets below this score (a mean ratio of 0.046): it takes some six tets more.
constexpr double kInsertionThreshold = 2e-5;

/// What the tets around an inserted vertex have to score before anything moves: as much as can be had. On the
/// boundary, whose faces may be needles, so many times the score of the tet that it is for.
constexpr std::array kLeastAroundInsertion{0.02, 0.005, 0.001, 2e-4, 4e-5};
constexpr double kTimesBetterOnSkin = 3.0;

FlipRule trial_rule(FlipRule rule) {
  rule.least_growth = -1e299;
  rule.least_of_worst = 0.0;
  return rule;
}

std::array<Index, 2> edge_of(const Tet& tet, std::size_t e) {
  return {tet[static_cast<std::size_t>(kTetEdges[e][0])], tet[static_cast<std::size_t>(kTetEdges[e][1])]};
}

}  // namespace

bool RepairSuccess::is_worth_it() const {
  return tries < kTriesPerHelp * (helped + 1);
}

bool RepairSuccess::note(bool has_helped) {
  ++tries;
  if (has_helped) ++helped;
  return has_helped;
}

Repairer::Repairer(WorkingMesh& mesh, const ScoreRule& scores, const FlipRule& rule, const RepairTools& tools)
    : mesh_(mesh),
      scores_(scores.with_gain_offset(kGainOffset)),
      tools_(tools),
      smoother_(mesh, scores_),
      flipper_(mesh, scores_, rule),
      trial_(mesh, scores_, trial_rule(rule)),
      cavity_(mesh, scores_) {
  if (!is_strict()) return;
  smoother_.set_least_of_worst(1.0);
  set_rule(rule);
}

void Repairer::set_rule(const FlipRule& rule) {
  FlipRule own = rule;
  if (is_strict()) own.least_of_worst = 1.0;
  flipper_.set_rule(own);
  trial_.set_rule(trial_rule(own));
}

void Repairer::set_floor(const QualityFloor* floor) {
  floor_ = floor;
  smoother_.set_floor(floor);
  flipper_.set_floor(floor);
}

void Repairer::set_manner(double threshold) {
  std::size_t bad = 0;
  for (Index t = 0; t < mesh_.tets.size(); ++t) {
    if (mesh_.is_alive(t) && flipper_.known_score(t) < threshold) ++bad;
  }
  const double share =
      static_cast<double>(bad) / static_cast<double>(std::max<std::uint64_t>(1, mesh_.alive));
  many_are_bad_ = share > kFewBad;
  scores_ = scores_.with_gain_offset(many_are_bad_ ? kGainOffsetOfMany : kGainOffset);
  smoother_.set_least_of_worst(is_strict() ? 1.0 : kLeastOfWorst);
  set_rule(flipper_.rule());
}

void Repairer::remember_more() {
  given_up_at_.resize(mesh_.tets.size(), WorkingMesh::kNoScore);
  hopeless_at_.resize(mesh_.tets.size(), WorkingMesh::kNoScore);
}

void Repairer::round(double threshold, double compound_threshold, int steps) {
  bad_.clear();
  remember_more();
  for (Index t = 0; t < mesh_.tets.size(); ++t) {
    if (mesh_.is_alive(t) && flipper_.known_score(t) < threshold) bad_.emplace_back(mesh_.score[t], t);
  }
  std::sort(bad_.begin(), bad_.end());
  // Where most tets are bad, as when the boundary is too fine for the count, no repair helps; the time is
  // bounded.
  const std::size_t share_of_compound = many_are_bad_ ? kShareOfCompoundOfMany : kShareOfCompound;
  const std::size_t share = compound_threshold > 0.0 ? share_of_compound : kShareOfRepair;
  if (bad_.size() > kAlwaysRepaired + mesh_.alive / share) bad_.resize(kAlwaysRepaired + mesh_.alive / share);
  for (const auto& [score, t] : bad_) {
    if (!mesh_.is_alive(t) || flipper_.known_score(t) >= threshold) continue;
    const Tet tet = mesh_.tets[t];
    if (given_up_at_[t] != mesh_.score[t]) {
      if (try_flips(t, tet) || try_moves(tet, steps)) continue;
      given_up_at_[t] = mesh_.score[t];
    }
    // A trial that is taken back may give the tet another slot: from here on its vertices stand for it.
    const double score_now = flipper_.known_score(t);
    if (score_now >= compound_threshold) continue;
    const bool is_split_wanted = score_now < kSplitThreshold;
    if (double{hopeless_at_[t]} != score_now) {
      if (is_worth_it(compound_) && compound_.note(try_compound(tet, score_now, steps))) continue;
      if (is_split_wanted && !many_are_bad_ && try_shifted_flips(tet, score_now, steps)) continue;
      remember_more();
      const Index slot = find_tet(mesh_, tet);
      flipper_.known_score(slot);
      hopeless_at_[slot] = given_up_at_[slot] = mesh_.score[slot];
    }
    if (is_split_wanted && is_worth_it(split_) && split_.note(try_splits(tet, score_now, steps))) continue;
    if (score_now < kInsertionThreshold && is_worth_it(insertion_))
      insertion_.note(try_insertions(tet, score_now, steps));
  }
}

bool Repairer::try_flips(Index t, const Tet& tet) {
  for (std::size_t e = 0; e < 6 && tools_.edge_removal; ++e) {
    const auto [a, b] = edge_of(tet, e);
    if (!flipper_.try_remove_edge(a, b)) continue;
    ++counts_.edges_removed;
    return true;
  }
  for (std::size_t corner = 0; corner < 4 && tools_.face_removal; ++corner) {
    if (!flipper_.try_remove_face(t, corner)) continue;
    ++counts_.faces_removed;
    return true;
  }
  return false;
}

bool Repairer::try_moves(const Tet& tet, int steps) {
  if (!tools_.smoothing) return false;
  bool moved = false;
  for (const Index v : tet) {
    if (!mesh_.is_free(v) || !(smoother_.smooth(v, steps) > 0.0)) continue;
    ++counts_.moves;
    moved = true;
  }
  return moved;
}

bool Repairer::try_compound(const Tet& tet, double score, int steps) {
  if (!tools_.compound_moves || !tools_.smoothing) return false;
  for (std::size_t e = 0; e < 6 && tools_.edge_removal; ++e) {
    const auto [a, b] = edge_of(tet, e);
    if (!trial_.try_remove_edge(a, b) || !keep_if_better(score, steps, true)) continue;
    ++counts_.edges_removed;
    return true;
  }
  for (std::size_t corner = 0; corner < 4 && tools_.face_removal; ++corner) {
    const Index t = find_tet(mesh_, tet);
    if (!trial_.try_remove_face(t, corner_in(mesh_.tets[t], tet[corner])) ||
        !keep_if_better(score, steps, true)) {
      continue;
    }
    ++counts_.faces_removed;
    return true;
  }
  return false;
}

bool Repairer::try_shifted_flips(const Tet& tet, double score, int steps) {
  if (!tools_.compound_moves || !tools_.smoothing || !tools_.edge_removal) return false;
  EdgeRing ring;
  for (std::size_t e = 0; e < 6; ++e) {
    const auto [a, b] = edge_of(tet, e);
    if (!find_edge_ring(mesh_, a, b, ring)) continue;
    const EdgeRing around = ring;
    for (std::size_t i = 0; i < around.size; ++i) {
      if (mesh_.is_free(around.ring[i]) && try_shift(around, around.ring[i], score, steps)) return true;
    }
  }
  return false;
}

bool Repairer::try_shift(const EdgeRing& ring, Index v, double score, int steps) {
  const Vec3 from = mesh_.points[v];
  const Vec3 away = from - 0.5 * (mesh_.points[ring.a] + mesh_.points[ring.b]);
  for (const double share : kShifts) {
    const Vec3 to = from + share * away;
    star_.start(scores_.at(from), from);
    add_star(mesh_, v, kNoIndex, star_);
    star_.close();
    if (!star_.is_positive(to)) continue;
    apply_move(mesh_, v, to);
    if (trial_.try_remove_edge(ring.a, ring.b)) {
      if (keep_if_better(score, steps, false)) {
        ++counts_.edges_removed;
        return true;
      }
    }
    apply_move(mesh_, v, from);
  }
  return false;
}

bool Repairer::try_splits(const Tet& tet, double score, int steps) {
  if (!tools_.edge_splits || !tools_.smoothing) return false;
  for (std::size_t e = 0; e < 6; ++e) {
    const auto [a, b] = edge_of(tet, e);
    if (trial_.split_edge(a, b) == kNoIndex || !keep_if_better(score, steps, true)) continue;
    ++counts_.splits;
    return true;
  }
  return false;
}

bool Repairer::try_insertions(const Tet& tet, double score, int steps) {
  if (!tools_.insertions || !tools_.smoothing) return false;
  propose_places(mesh_, find_tet(mesh_, tet), proposed_);
  for (const double inside : kLeastAroundInsertion) {
    for (const Vec3& place : proposed_) {
      // A trial that is taken back may give the tet another slot.
      const Index slot = find_tet(mesh_, tet);
      if (!cavity_.grow(slot, place, {inside, std::min(inside, kTimesBetterOnSkin * score)}) ||
          trial_.insert_vertex(cavity_.tets(), place, cavity_.faces()) == kNoIndex ||
          !keep_if_better(score, steps, true)) {
        continue;
      }
      ++counts_.insertions;
      return true;
    }
  }
  return false;
}

/// The worst of the tets that a trial and the moves after it have changed, or the first one found below
/// `enough`.
double Repairer::worst_around(double enough) {
  double worst = 1e300;
  const auto is_below = [&](Index t) {
    worst = std::min(worst, flipper_.known_score(t));
    return worst < enough;
  };
  if (std::any_of(trial_.added().begin(), trial_.added().end(), is_below)) return worst;
  for (const Index v : vertices_) {
    const auto star = mesh_.star(v);
    if (std::any_of(star.begin(), star.end(), is_below)) return worst;
  }
  return worst;
}

/// Exchanges where the vertices that may move are for where they were.
void Repairer::swap_places() {
  for (std::size_t i = 0; i < vertices_.size(); ++i) std::swap(mesh_.points[vertices_[i]], places_[i]);
}

/// The scores around the vertices that may move, known or not.
void Repairer::note_scores(std::vector<float>& scores) const {
  scores.clear();
  for (const Index v : vertices_) {
    for (const Index t : mesh_.star(v)) scores.push_back(mesh_.score[t]);
  }
}

void Repairer::put_scores(const std::vector<float>& scores) {
  auto score = scores.begin();
  for (const Index v : vertices_) {
    for (const Index t : mesh_.star(v)) mesh_.score[t] = *score++;
  }
}

/// The worst of the tets that the trial has left alone, around the vertices that may move, as they were
/// before these moved. Few trials come so far that it is asked for, so it is found then.
double Repairer::worst_beside() {
  note_scores(scores_after_);
  swap_places();
  put_scores(scores_before_);
  const auto& added = trial_.added();
  double worst = 1e300;
  for (const Index v : vertices_) {
    for (const Index t : mesh_.star(v)) {
      if (std::find(added.begin(), added.end(), t) == added.end())
        worst = std::min(worst, flipper_.known_score(t));
    }
  }
  swap_places();
  put_scores(scores_after_);
  return worst;
}

/// Whether no tet that a trial and the moves after it have changed is below the floor.
bool Repairer::is_above_floor() const {
  if (floor_ == nullptr) return true;
  const auto is_above = [&](Index t) { return floor_->admits(mesh_, mesh_.tets[t]); };
  const auto& added = trial_.added();
  return std::all_of(added.begin(), added.end(), is_above) &&
         std::all_of(vertices_.begin(), vertices_.end(), [&](Index v) {
           const auto star = mesh_.star(v);
           return std::all_of(star.begin(), star.end(), is_above);
         });
}

/// One sweep over the vertices that may move. One that was tried in vain is not tried again before something
/// around it has moved. Returns what was gained.
double Repairer::sweep_around(int steps) {
  constexpr std::uint32_t kInVain = 1;
  constexpr std::uint32_t kOpen = 2;
  double gained = 0.0;
  for (const Index v : vertices_) {
    if (marks_.of(v) == kInVain) continue;
    const double gain = smoother_.smooth(v, steps);
    marks_.set(v, kInVain);
    if (!(gain > 0.0)) continue;
    gained += gain;
    for (const Index t : mesh_.star(v)) {
      for (const Index w : mesh_.tets[t]) marks_.set(w, kOpen);
    }
  }
  return gained;
}

bool Repairer::keep_if_better(double score, int steps, bool by_sum) {
  vertices_.clear();
  places_.clear();
  for (const Index t : trial_.added()) {
    for (const Index v : mesh_.tets[t]) {
      if (!mesh_.is_free(v) || std::find(vertices_.begin(), vertices_.end(), v) != vertices_.end()) continue;
      vertices_.push_back(v);
      places_.push_back(mesh_.points[v]);
    }
  }
  if (is_strict() && by_sum) note_scores(scores_before_);
  double growth = trial_.growth();
  smoother_.set_floor(nullptr);
  marks_.clear(mesh_.points.size());
  for (int left = kSweepsOfCompound - 1; left >= 0; --left) {
    const double gained = sweep_around(steps);
    growth += gained;
    // A sweep gains less than the one before it.
    if (growth + left * gained <= flipper_.rule().least_growth) break;
  }
  smoother_.set_floor(floor_);
  const bool is_sum_better = by_sum && growth > flipper_.rule().least_growth;
  // What the trial itself has made may be anything: the smoothing is what makes it good.
  const double least = is_strict() && is_sum_better ? std::min(score, worst_beside()) : 0.0;
  const double worst =
      worst_around(is_sum_better ? std::min(least, kWorthAnyway * score) : kWorthAnyway * score);
  const bool is_better = (is_sum_better && worst >= least) || worst > kWorthAnyway * score;
  if (is_better && is_above_floor()) {
    counts_.moves += vertices_.size();
    return true;
  }
  for (std::size_t i = 0; i < vertices_.size(); ++i) apply_move(mesh_, vertices_[i], places_[i]);
  trial_.undo();
  return false;
}

}  // namespace palpate::simplify

#include "core/simplify/refined/stable_step.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::simplify {
namespace {

/// A change has to take this share off the greatest rate that it touches.
constexpr double kLeastGain = 0.005;

/// Rates are looked at down to this share of the greatest: steps an eighth longer.
constexpr double kWithin = 0.8;

/// No change leaves a lower score, unless it found one.
constexpr double kGuardScore = 0.08;

/// Steps along the gradient, and the difference that it is got by, in lengths of an edge.
constexpr double kFirstStepOfRate = 0.3;
constexpr double kDifferenceOfRate = 1e-4;
constexpr double kShorterOfRate = 0.4;  ///< factor of a step that was too long
constexpr int kStepsOfRate = 4;
constexpr int kTriesOfRate = 5;

/// So often the vertices of a flip move.
constexpr int kSweepsOfFlip = 2;

/// Tries to see to a vertex in a whole run: so many, and one for so many vertices of the mesh.
constexpr std::size_t kLeastTries = 64;
constexpr std::size_t kVerticesPerTry = 4;

/// A round that takes less than this share off the greatest rate is the last.
constexpr double kLeastGainOfRound = 0.01;

/// So often one vertex is seen to in a round.
constexpr int kTriesOfVertex = 4;

/// Shares of a move of the skin, where it permits no more.
constexpr std::array kSharesOfSkinMove{1.0, 0.5, 0.25, 0.125};

/// Sums of this power of the rates stand for the greatest one, so that it has a gradient.
double power_of(double x) {
  const double square = x * x;
  return square * square * square;
}

/// Sorts, and leaves one of each.
template <typename T>
void make_set(std::vector<T>& values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

FlipRule any_flip(FlipRule rule) {
  rule.least_growth = -1e299;
  rule.least_of_worst = 0.0;
  return rule;
}

}  // namespace

StepLengthener::StepLengthener(WorkingMesh& mesh, const ScoreRule& scores, const FlipRule& window,
                               SkinMoves* skin)
    : mesh_(mesh), scores_(scores), trial_(mesh, scores_, any_flip(window)), skin_(skin) {}

void StepLengthener::renew(Index v) {
  known_[v] = measure_vertex(mesh_, v);
  rates_[v] = known_[v].rate();
}

double StepLengthener::greatest(const std::vector<Index>& vertices) const {
  double most = 0.0;
  for (const Index v : vertices) most = std::max(most, rates_[v]);
  return most;
}

void StepLengthener::collect_link(Index v, std::vector<Index>& out) const {
  out.clear();
  for (const Index t : mesh_.star(v)) {
    for (const Index w : mesh_.tets[t]) {
      if (w != v) out.push_back(w);
    }
  }
  make_set(out);
}

void StepLengthener::run(int rounds) {
  known_.assign(mesh_.points.size(), {});
  rates_.assign(mesh_.points.size(), 0.0);
  for (Index v = 0; v < mesh_.points.size(); ++v) {
    if (mesh_.is_vertex_alive(v)) renew(v);
  }
  tries_left_ = kLeastTries + mesh_.points.size() / kVerticesPerTry;
  for (int i = 0; i < rounds; ++i) {
    if (!round()) return;
  }
}

/// The vertices with the greatest rates, the greatest first (ties: the smallest number). What lies well below
/// one that nothing helps is left alone: it holds nothing down.
bool StepLengthener::round() {
  const double most = *std::max_element(rates_.begin(), rates_.end());
  std::vector<std::pair<double, Index>> order;
  for (Index v = 0; v < mesh_.points.size(); ++v) {
    if (rates_[v] > 0.0 && rates_[v] >= kWithin * most) order.emplace_back(-rates_[v], v);
  }
  std::sort(order.begin(), order.end());
  bool has_changed = false;
  double stuck = 0.0;
  for (const auto& [unused, v] : order) {
    if (rates_[v] < kWithin * stuck) continue;
    int helped = 0;
    while (helped < kTriesOfVertex && tries_left_ > 0 && improve(v)) ++helped;
    if (tries_left_ == 0) return false;
    has_changed = has_changed || helped > 0;
    if (helped == 0) stuck = std::max(stuck, rates_[v]);
  }
  return has_changed && *std::max_element(rates_.begin(), rates_.end()) < (1.0 - kLeastGainOfRound) * most;
}

bool StepLengthener::improve(Index v) {
  --tries_left_;
  return try_moves(v) || try_flips(v, false) || try_flips(v, true);
}

bool StepLengthener::try_moves(Index v) {
  std::vector<Index> around;
  collect_link(v, around);
  around.insert(around.begin(), v);
  bool helped = false;
  for (const Index w : around) {
    if (mesh_.is_free(w))
      helped = try_move(w) || helped;
    else if (skin_ != nullptr && skin_->may_move(w))
      helped = try_skin_move(w) || helped;
  }
  return helped;
}

StepLengthener::Place StepLengthener::look_at(const Vec3& place) {
  sums_ = rest_;
  VertexRate own;
  for (const StarTet& t : star_tets_) {
    add_tet(place, {&mesh_.points[link_[t[0]]], &mesh_.points[link_[t[1]]], &mesh_.points[link_[t[2]]]},
            {&own, &sums_[t[0]], &sums_[t[1]], &sums_[t[2]]}, 1.0);
  }
  sums_.push_back(own);
  Place result{place, 0.0, 0.0};
  for (const VertexRate& each : sums_) {
    const double rate = each.rate();
    result.powers += power_of(rate / reference_);
    result.most = std::max(result.most, rate);
  }
  return result;
}

/// Rates around v without its tets, and these tets.
void StepLengthener::take_star(Index v) {
  collect_link(v, link_);
  rest_.clear();
  rest_.reserve(link_.size());
  for (const Index w : link_) rest_.push_back(known_[w]);
  star_tets_.clear();
  VertexRate own;
  for (const Index t : mesh_.star(v)) {
    const Triangle base = face_opposite(mesh_.tets[t], corner_in(mesh_.tets[t], v));
    StarTet local{};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto at = std::lower_bound(link_.begin(), link_.end(), base[i]);
      local[i] = static_cast<std::size_t>(at - link_.begin());
    }
    add_tet(mesh_.points[v], {&mesh_.points[base[0]], &mesh_.points[base[1]], &mesh_.points[base[2]]},
            {&own, &rest_[local[0]], &rest_[local[1]], &rest_[local[2]]}, -1.0);
    star_tets_.push_back(local);
  }
  star_.start(scores_.at(mesh_.points[v]), mesh_.points[v]);
  add_star(mesh_, v, kNoIndex, star_);
  star_.close();
  reference_ = std::max(greatest(link_), rates_[v]);
}

/// Down the gradient of the sum of powers, by forward differences, as long as the greatest rate falls.
StepLengthener::Place StepLengthener::descend(const Vec3& from, double edge, const Vec3& normal) {
  const double guard = std::min(star_.evaluate(from).worst, kGuardScore);
  Place here = look_at(from);
  double step = kFirstStepOfRate * edge;
  const double d = kDifferenceOfRate * edge;
  const double size_sq = length_sq(normal);
  for (int i = 0; i < kStepsOfRate; ++i) {
    Vec3 gradient{look_at(here.at + Vec3{d, 0.0, 0.0}).powers - here.powers,
                  look_at(here.at + Vec3{0.0, d, 0.0}).powers - here.powers,
                  look_at(here.at + Vec3{0.0, 0.0, d}).powers - here.powers};
    if (size_sq > 0.0) gradient = gradient - (dot(gradient, normal) / size_sq) * normal;
    const double norm = length(gradient);
    if (!(norm > 0.0)) break;
    bool is_better = false;
    for (int k = 0; k < kTriesOfRate && !is_better; ++k) {
      const Place there = look_at(here.at - (step / norm) * gradient);
      is_better = there.powers < here.powers && there.most <= here.most &&
                  star_.evaluate(there.at, guard).worst >= guard;
      if (is_better)
        here = there;
      else
        step *= kShorterOfRate;
    }
    if (!is_better) break;
  }
  return here;
}

void StepLengthener::put(Index v, const Vec3& place) {
  apply_move(mesh_, v, place);
  renew(v);
  for (const Index w : link_) renew(w);
}

bool StepLengthener::try_move(Index v) {
  take_star(v);
  const Vec3 from = mesh_.points[v];
  const double before = look_at(from).most;
  const Place found = descend(from, length(mesh_.points[link_[0]] - from));
  if (!(found.most < (1.0 - kLeastGain) * before) || !star_.is_positive(found.at)) return false;
  put(v, found.at);
  ++counts_.moves;
  return true;
}

/// The same for a vertex of the skin, within its plane, as far as the skin permits.
bool StepLengthener::try_skin_move(Index v) {
  take_star(v);
  const Vec3 from = mesh_.points[v];
  const double before = look_at(from).most;
  const double guard = std::min(star_.evaluate(from).worst, kGuardScore);
  const Vec3 whole = descend(from, length(mesh_.points[link_[0]] - from), skin_->normal_at(v)).at - from;
  for (const double share : kSharesOfSkinMove) {
    const Vec3 to = from + share * whole;
    if (!(look_at(to).most < (1.0 - kLeastGain) * before)) return false;
    if (star_.evaluate(to, guard).worst < guard || !star_.is_positive(to) || !skin_->take_move(v, to))
      continue;
    put(v, to);
    ++counts_.moves;
    return true;
  }
  return false;
}

/// Moves v wherever it is better, by however little.
void StepLengthener::settle(Index v) {
  take_star(v);
  const Vec3 from = mesh_.points[v];
  const Place found = descend(from, length(mesh_.points[link_[0]] - from));
  if (star_.is_positive(found.at)) put(v, found.at);
}

bool StepLengthener::try_flips(Index v, bool with_moves) {
  std::vector<Tet> tets;  // a flip that is taken back may give a tet another slot
  std::vector<std::pair<Index, Index>> edges;
  tets.reserve(mesh_.star_size[v]);
  edges.reserve(6 * std::size_t{mesh_.star_size[v]});
  for (const Index t : mesh_.star(v)) {
    const Tet& tet = tets.emplace_back(mesh_.tets[t]);
    for (const auto& e : kTetEdges)
      edges.emplace_back(
          std::minmax(tet[static_cast<std::size_t>(e[0])], tet[static_cast<std::size_t>(e[1])]));
  }
  make_set(edges);
  for (const auto& [a, b] : edges) {
    if (!trial_.try_remove_edge(a, b) || !(with_moves ? keep_flip_with_moves() : keep_flip())) continue;
    ++counts_.edges_removed;
    return true;
  }
  for (const Tet& tet : tets) {
    for (const Index opposite : tet) {
      const Index t = find_tet(mesh_, tet);
      if (!trial_.try_remove_face(t, corner_in(mesh_.tets[t], opposite)) ||
          !(with_moves ? keep_flip_with_moves() : keep_flip()))
        continue;
      ++counts_.faces_removed;
      return true;
    }
  }
  return false;
}

/// The vertices of the last flip's tets, and the least score of these before it.
double StepLengthener::take_flip() {
  touched_.clear();
  double worst = 1e300;
  for (const Tet& tet : trial_.removed()) {
    touched_.insert(touched_.end(), tet.begin(), tet.end());
    const Vec3& a = mesh_.points[tet[0]];
    worst = std::min(worst, double{score_tet(scores_.at(a), a, mesh_.points[tet[1]], mesh_.points[tet[2]],
                                             mesh_.points[tet[3]])});
  }
  make_set(touched_);
  return worst;
}

/// Keeps the last flip if it helps, else takes it back.
bool StepLengthener::keep_flip() {
  const double guard = std::min(take_flip(), kGuardScore);
  const double before = greatest(touched_);
  double worst = 1e300;
  for (const Index t : trial_.added()) worst = std::min(worst, trial_.known_score(t));
  if (worst >= guard) {
    for (const Index w : touched_) renew(w);
    if (greatest(touched_) < (1.0 - kLeastGain) * before) return true;
  }
  trial_.undo();
  for (const Index w : touched_) renew(w);
  return false;
}

/// Moves the free vertices of the last flip as well, and keeps it all if it helps.
bool StepLengthener::keep_flip_with_moves() {
  double guard = take_flip();
  const std::vector<Index> flipped = touched_;
  std::vector<std::pair<Index, Vec3>> places;
  for (const Index v : flipped) {
    if (!mesh_.is_free(v)) continue;
    places.emplace_back(v, mesh_.points[v]);
    collect_link(v, link_);
    touched_.insert(touched_.end(), link_.begin(), link_.end());
  }
  make_set(touched_);
  const double before = greatest(touched_);
  const auto& added = trial_.added();
  for (const auto& [v, unused] : places) {
    for (const Index t : mesh_.star(v)) {
      if (std::find(added.begin(), added.end(), t) == added.end())
        guard = std::min(guard, trial_.known_score(t));
    }
  }
  guard = std::min(guard, kGuardScore);
  for (const Index v : flipped) renew(v);
  for (int sweep = 0; sweep < kSweepsOfFlip; ++sweep) {
    for (const auto& [v, unused] : places) settle(v);
  }
  double worst = 1e300;
  for (const Index v : flipped) {
    for (const Index t : mesh_.star(v)) worst = std::min(worst, trial_.known_score(t));
  }
  if (worst >= guard && greatest(touched_) < (1.0 - kLeastGain) * before) {
    counts_.moves += places.size();
    return true;
  }
  for (const auto& [v, place] : places) apply_move(mesh_, v, place);
  trial_.undo();
  for (const Index v : touched_) renew(v);
  return false;
}

}  // namespace palpate::simplify

#include "experiments/fit/candidates/fit_prospects.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <map>
#include <optional>

namespace palpate::experiments {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::infinity();
constexpr double kNearMiss = 1.05;  // of the tolerance

bool is_same_candidate(const FitCandidate& a, const FitCandidate& b) {
  return plan_label(a) == plan_label(b);
}

/// A share of one model and simplifier, as far as it is known.
struct KnownShare {
  const FitPoint* point;
  bool is_checked;
  bool meets;      ///< on all loads where it was checked, on the scene itself else
  bool is_likely;  ///< it meets all on other loads too, as far as its model is known
  double cost_s;
  double lowered_s;  ///< what others of its model and simplifier make of that
  double expected;   ///< the worst error on all loads: as it was checked, else that on the scene times its
                     ///< model's growth
};

/// Gives shares of one model and simplifier, and what `found` has of them, the costs as they are lowered.
void lower_costs(std::vector<KnownShare>& shares, std::vector<FitProspect>& found) {
  for (KnownShare& share : shares) {
    if (std::isfinite(share.cost_s)) share.cost_s = share.lowered_s;
    for (FitProspect& each : found) {
      if (is_same_candidate(each.candidate, share.point->candidate)) each.cost_s = share.cost_s;
    }
  }
}

/// Whether what lies above a share may meet all, and cost less than it or than what does: it meets all and
/// the next one up does not, or both miss it and one of them by little (errors need not grow with the share).
bool is_worth_halving(const KnownShare& low, const KnownShare* high, double at_most) {
  if (high == nullptr || high->meets) return high == nullptr && low.meets;
  return low.meets || std::min(low.expected, high->expected) <= kNearMiss * at_most;
}

/// What a share above the greatest one costs: by its tetrahedra, or by how the cost fell from the share
/// below, if that is more. A table of compliances costs the same on whatever mesh.
double cost_above(const KnownShare& low, const KnownShare* below, double kept_ratio, double step) {
  const double by_tets = low.cost_s * kept_ratio;
  if (below == nullptr || !std::isfinite(below->cost_s)) return by_tets;
  const double from = below->point->candidate.removed();
  const double slope = (below->cost_s - low.cost_s) / (low.point->candidate.removed() - from);
  return std::max(by_tets, low.cost_s - slope * step);
}

/// The middle between a share and the next one up, `below` the one before it (null: none); null: nothing is
/// there.
std::optional<FitProspect> prospect_above(const KnownShare* below, const KnownShare& low,
                                          const KnownShare* high, const std::string& simplifier) {
  constexpr double kAll = 1.0;  // no mesh is left there
  const double from = low.point->candidate.removed();
  const double to = high == nullptr ? kAll : high->point->candidate.removed();
  if (to - from < 2.0 * kLeastShareStep) return std::nullopt;
  constexpr double kThousandth = 1000.0;  // names of shares have so many digits
  const double middle = std::round(kThousandth * 0.5 * (from + to)) / kThousandth;
  FitProspect found;
  found.candidate = low.point->candidate;
  found.candidate.simplifier = simplifier;
  found.candidate.ratio = middle;
  const double cost = low.cost_s;
  const bool is_between = high != nullptr && std::isfinite(high->cost_s);
  found.cost_s = is_between ? cost + (high->cost_s - cost) * (middle - from) / (to - from)
                            : cost_above(low, below, (kAll - middle) / (kAll - from), middle - from);
  found.expected_error = high == nullptr
                             ? kUnknown
                             : low.expected + (high->expected - low.expected) * (middle - from) / (to - from);
  found.is_likely = low.meets && low.is_likely;
  found.is_between = true;
  return found;
}

/// By model, all that is known of it, the fewest tetrahedra removed first: a check says more than the search.
std::map<std::string, std::vector<KnownShare>> known_shares(const std::vector<FitPoint>& searched,
                                                            const std::vector<FitPoint>& checked,
                                                            const SceneRequirement& require) {
  std::map<std::string, std::vector<KnownShare>> known;
  for (const FitPoint& point : checked) {
    const FitPoint* refused = find_better_refused(point, checked, require);
    const bool meets = refused == nullptr && why_not(point, require).empty();
    const double expected =
        refused == nullptr ? point.known_error() : std::max(point.worst_error(), refused->known_error());
    const double lowered = lowered_cost(point, searched, checked);
    known[point.candidate.model.label].push_back(
        {&point, true, meets, true, point.cost(), lowered, expected});
  }
  for (const FitPoint& point : searched) {
    if (find_point(checked, point.candidate) != nullptr) continue;
    const std::string& model = point.candidate.model.label;
    const bool meets = why_not(point, require).empty();
    const double expected = point.worst_error() * growth_on_loads(searched, checked, model);
    const bool is_likely = meets && expected <= require.at_most;
    const double lowered = lowered_cost(point, searched, checked);
    known[model].push_back({&point, false, meets, is_likely, point.cost(), lowered, expected});
  }
  for (auto& [model, shares] : known) {
    std::stable_sort(shares.begin(), shares.end(), [](const KnownShare& a, const KnownShare& b) {
      return a.point->candidate.removed() < b.point->candidate.removed();
    });
  }
  return known;
}

/// Adds what lies between one model's shares by one simplifier, and lowers what `found` has of them.
void add_between(const std::vector<KnownShare>& shares, const std::string& simplifier, double at_most,
                 std::vector<FitProspect>& found) {
  std::vector<KnownShare> own;
  std::copy_if(shares.begin(), shares.end(), std::back_inserter(own),
               [&](const KnownShare& share) { return share.point->candidate.is_share_of(simplifier); });
  lower_costs(own, found);
  for (std::size_t k = 0; k < own.size(); ++k) {
    const KnownShare* below = k > 0 ? &own[k - 1] : nullptr;
    const KnownShare* next = k + 1 < own.size() ? &own[k + 1] : nullptr;
    if (!is_worth_halving(own[k], next, at_most)) continue;
    if (const auto middle = prospect_above(below, own[k], next, simplifier)) found.push_back(*middle);
  }
}

/// Of what costs the same within noise, from the cheapest on: the most accurate and the cheapest by turns.
void alternate(std::vector<FitProspect>::iterator from, std::vector<FitProspect>::iterator to) {
  std::vector<FitProspect> cheap(from, to);
  std::vector<const FitProspect*> accurate;
  accurate.reserve(cheap.size());
  for (const FitProspect& each : cheap) accurate.push_back(&each);
  std::stable_sort(accurate.begin(), accurate.end(), [](const FitProspect* a, const FitProspect* b) {
    return a->expected_error < b->expected_error;
  });
  std::vector<std::uint8_t> is_taken(cheap.size(), 0);
  const auto take = [&](const FitProspect& each) {
    std::uint8_t& taken = is_taken[static_cast<std::size_t>(&each - cheap.data())];
    if (taken == 0) *from++ = each;
    taken = 1;
  };
  for (std::size_t k = 0; k < cheap.size(); ++k) {
    take(*accurate[k]);
    take(cheap[k]);
  }
}

/// The likely ones first, the cheapest of each first, but for what costs the same.
void sort_prospects(std::vector<FitProspect>& found) {
  // Fewer tetrahedra are cheaper where times say nothing.
  std::stable_sort(found.begin(), found.end(), [](const FitProspect& a, const FitProspect& b) {
    if (a.is_likely != b.is_likely) return a.is_likely;
    return a.cost_s != b.cost_s ? a.cost_s < b.cost_s : a.candidate.removed() > b.candidate.removed();
  });
  for (auto from = found.begin(); from != found.end();) {
    const auto to = std::find_if(from, found.end(), [&](const FitProspect& each) {
      return each.is_likely != from->is_likely || each.cost_s > kSameCost * from->cost_s;
    });
    alternate(from, to);
    from = to;
  }
}

}  // namespace

double growth_on_loads(const std::vector<FitPoint>& searched, const std::vector<FitPoint>& checked,
                       const std::string& model) {
  double growth = 1.0;
  for (const FitPoint& point : checked) {
    if (point.candidate.model.label != model || point.error.empty()) continue;
    const FitPoint* own = find_point(searched, point.candidate);
    const double alone = own != nullptr && !own->error.empty()
                             ? own->worst_error()
                             : point.error.front() + point.own_error.front();
    if (alone > 0.0 && std::isfinite(point.known_error()))
      growth = std::max(growth, point.known_error() / alone);
  }
  return growth;
}

double lowered_cost(const FitPoint& point, const std::vector<FitPoint>& searched,
                    const std::vector<FitPoint>& checked) {
  const FitCandidate& own = point.candidate;
  double least = point.cost();
  const auto lower = [&](const FitPoint& other) {
    const FitCandidate& candidate = other.candidate;
    const bool is_finer = candidate.model.label == own.model.label && candidate.is_share_of(own.simplifier) &&
                          candidate.removed() <= own.removed();
    if (is_finer) least = std::min(least, other.cost());
  };
  std::for_each(checked.begin(), checked.end(), lower);
  for (const FitPoint& other : searched) {
    if (find_point(checked, other.candidate) == nullptr) lower(other);
  }
  return least;
}

std::vector<FitProspect> list_prospects(const std::vector<FitPoint>& searched,
                                        const std::vector<FitPoint>& checked, const FitCandidates& candidates,
                                        const SceneRequirement& require, double most_cost_s) {
  std::vector<FitProspect> found;
  for (auto& [model, shares] : known_shares(searched, checked, require)) {
    for (const KnownShare& share : shares) {
      if (!share.is_checked && share.meets)
        found.push_back({share.point->candidate, share.cost_s, share.expected, share.is_likely, false});
    }
    for (const FitSimplifier& simplifier : candidates.simplifiers) {
      if (!simplifier.grade) add_between(shares, simplifier.label, require.at_most, found);
    }
  }
  const auto is_out = [&](const FitProspect& each) {
    return !(each.cost_s < most_cost_s) || find_point(checked, each.candidate) != nullptr;
  };
  found.erase(std::remove_if(found.begin(), found.end(), is_out), found.end());
  sort_prospects(found);
  return found;
}

std::vector<FitCandidate> take_prospects(const std::vector<FitProspect>& prospects, std::size_t count,
                                         bool has_choice) {
  std::vector<FitCandidate> taken;
  const auto take = [&](std::size_t most, bool between) {
    for (const FitProspect& each : prospects) {
      const bool is_new = std::none_of(taken.begin(), taken.end(), [&](const FitCandidate& other) {
        return is_same_candidate(other, each.candidate);
      });
      if (taken.size() < most && is_new && (between || !each.is_between)) taken.push_back(each.candidate);
    }
  };
  if (!has_choice) take((count + 1) / 2, false);
  take(count, true);
  return taken;
}

}  // namespace palpate::experiments

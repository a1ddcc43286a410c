#include "core/simplify/refined/refined.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/topology.h"

namespace palpate::simplify {
namespace {

/// What an effort means.
struct Effort {
  double stage_share;      ///< a stage collapses down to this share of its tets
  double stage_threshold;  ///< during the stages, tets below this score are flipped
  int stage_steps;         ///< gradient steps of a stage's sweep
  double stage_aim;        ///< stages but the first aim at this count, relative to the wanted one
  double last_aim;         ///< collapses behind them aim at this one
  double final_threshold;  ///< then tets below this score are flipped
  int final_steps;         ///< gradient steps of a sweep then
  int last_steps;          ///< the same of the sweep before repairs
  int passes;              ///< least number of stages and final rounds together
  double repair_threshold;
  double compound_threshold;
  int repair_rounds;
};

constexpr std::array<Effort, kMostEffort + 1> kEfforts{
    {{0.85, 0.05, 0, 1.06, 1.020, 0.09, 1, 0, 2, 0.08, 0.03, 1},
     {0.80, 0.06, 0, 1.02, 1.012, 0.18, 1, 1, 5, 0.13, 0.05, 2},
     {0.78, 0.08, 0, 1.02, 1.012, 0.25, 2, 1, 6, 0.16, 0.08, 3},
     {0.80, 0.10, 0, 1.02, 1.012, 0.30, 2, 1, 9, 0.18, 0.10, 4},
     {0.85, 0.15, 0, 1.02, 1.012, 0.40, 3, 1, 14, 0.20, 0.12, 6},
     {0.90, 0.20, 1, 1.02, 1.012, 1.00, 3, 1, 24, 0.25, 0.14, 8}}};

/// With thresholds in the scale's own scores.
Effort effort_of(int level, const ScoreScale& scale) {
  Effort effort = kEfforts.at(static_cast<std::size_t>(level));
  effort.stage_threshold *= scale.flip_share;
  effort.final_threshold *= scale.flip_share;
  effort.repair_threshold *= scale.repair_share;
  effort.compound_threshold *= scale.repair_share;
  return effort;
}

/// Edges with more tets around them are left to repairs: of 630 thousand on 27 skins 112 were worth a flip.
constexpr std::size_t kLargestRingOfSweeps = 5;

/// The count, relative to the wanted one, that the first stage aims at: the first flips of a mesh take more
/// tets away than later ones do.
constexpr double kFirstAim = 1.06;

/// A stage that falls short of its goal has to leave less than this share of the tets to be followed by
/// another.
constexpr double kLeastProgress = 0.98;

/// Flips never take a mesh below these, relative to the wanted count.
constexpr double kLeastShareInStages = 1.002;
constexpr double kLeastShare = 0.998;

/// Repairs before the last collapses may leave so many more.
constexpr double kRoomForSplits = 1.012;

/// Repairs take more tets away than they add, so they begin with a few too many.
constexpr double kRepairAim = 1.003;

/// The last collapses for splits aim no lower; one collapse may go a few tets further.
constexpr double kLeastShareWithRoom = 0.998;
constexpr std::uint64_t kTetsOfASplit = 5;

/// The search for the fewest tets: where it starts and where nothing is left, by faces of the skin, and how
/// close it comes.
constexpr std::uint64_t kSafeTetsPerFace = 2;
constexpr double kTetsPerFaceOfNone = 4.0;
constexpr double kLimitResolution = 1.01;
/// A run of it is given up where collapses leave so many times what it would have to: what comes after them
/// took less than that away on each of twenty bodies, more than 2% on one.
constexpr double kHopeless = 1.03;
constexpr std::array kBelowLimit{0.99, 0.98, 0.995};  ///< tried from there, in this order

/// What collapses may leave, from strict to anything positive. The steps are small, as the last of many
/// collapses are made where nothing good is left: there each should leave the best that there is.
constexpr std::array kLeastScores{3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6,
                                  1e-6, 3e-7, 1e-7, 3e-8, 1e-8, 3e-9, 1e-9};
constexpr std::array kLastLeastScore{0.04};  ///< of the last few, with little repair to come

std::uint64_t share_of(std::uint64_t count, double share) {
  return static_cast<std::uint64_t>(static_cast<double>(count) * share);
}

class Run {
 public:
  Run(WorkingMesh&& mesh, const ScoreRule& scores, const RefinedOptions& options, std::uint64_t target)
      : mesh_(std::move(mesh)),
        scores_(scores),
        options_(options),
        effort_(effort_of(options.effort, scores.far())),
        target_(target),
        smoother_(mesh_, scores_),
        flipper_(mesh_, scores_, {}),
        repairer_(mesh_, scores_, {}, options.tools) {}

  void simplify() {
    if (!reduce() || options_.objective != Objective::kStableStep) return;
    StepLengthener lengthener(mesh_, scores_, final_rule());
    lengthener.run(kStepRounds);
    step_ = lengthener.counts();
  }

  WorkingMesh& mesh() { return mesh_; }
  const CollapseReport& collapses() const { return collapses_; }
  RepairCounts counts() const {
    RepairCounts sum = repairer_.counts();
    sum.moves += counts_.moves + step_.moves;
    sum.edges_removed += counts_.edges_removed + step_.edges_removed;
    sum.faces_removed += step_.faces_removed;
    return sum;
  }

 private:
  static constexpr int kCompoundSteps = 4;
  static constexpr double kVeryBad = 0.03;  ///< scores that are worth giving up a vertex elsewhere

  /// Down to the wanted count, for quality. Returns false if it was abandoned.
  bool reduce() {
    const Descent descent = options_.interleave ? go_down() : Descent{};
    if (!descent.is_exhausted) collapse_to(share_of(target_, effort_.last_aim));
    if (static_cast<double>(mesh_.alive) > options_.abandon_beyond * static_cast<double>(target_))
      return false;
    set_window(kLeastShareInStages, mesh_.alive);
    const int rounds = std::max(1, effort_.passes - descent.stages);
    for (int i = 0; i < rounds; ++i) {
      sweep(effort_.final_steps);
      flip_below(effort_.final_threshold);
    }
    if (options_.repair) repairer_.set_manner(effort_.repair_threshold);
    // Room for splits is there before the last collapses only.
    if (options_.repair)
      repair(0, 0.5 * effort_.compound_threshold,
             rule_of(kLeastShareInStages, is_short() ? mesh_.alive : share_of(mesh_.alive, kRoomForSplits)));
    collapse_last(options_.repair ? share_of(target_, kRepairAim) : target_);
    sweep(effort_.last_steps);
    if (!options_.repair) return true;
    if (options_.tools.never_worse) hold_floor();
    repair(rounds_at_the_end(), effort_.compound_threshold, final_rule());
    if (mesh_.alive > target_) {
      collapse_last(target_);
      if (floor_ && mesh_.alive > target_) give_up_floor();
      repair(1, effort_.compound_threshold, final_rule());
    }
    if (!repairer_.are_many_bad()) make_room_for_splits();
    return true;
  }

  struct Descent {
    int stages = 0;
    bool is_exhausted = false;  ///< no inner edge is left that could be collapsed
  };

  Descent go_down() {
    Descent descent;
    double aim = kFirstAim;
    while (mesh_.alive > share_of(target_, aim)) {
      const std::uint64_t before = mesh_.alive;
      const std::uint64_t goal = std::max(share_of(target_, aim), share_of(before, effort_.stage_share));
      collapse_to(goal);
      // Where the boundary forbids more, another stage would only repeat this one.
      descent.is_exhausted = mesh_.alive > goal && mesh_.alive >= share_of(before, kLeastProgress);
      if (descent.is_exhausted) break;
      set_window(kLeastShareInStages, before - 1);  // so that the count falls from stage to stage
      sweep(effort_.stage_steps);
      flip_below(effort_.stage_threshold);
      aim = effort_.stage_aim;
      ++descent.stages;
    }
    return descent;
  }

  /// Whether collapses have ended far above the wanted count: then no repair may take it up again.
  bool is_short() const { return mesh_.alive > share_of(target_, kShort); }

  /// Where many are bad more rounds mend little: half of them.
  int rounds_at_the_end() const {
    return repairer_.are_many_bad() ? (effort_.repair_rounds + 1) / 2 : effort_.repair_rounds;
  }

  FlipRule final_rule() const { return rule_of(kLeastShare, std::max<std::uint64_t>(target_, mesh_.alive)); }

  /// A tet that only a split helps needs tets to spare, which a collapse elsewhere gives.
  void make_room_for_splits() {
    const std::uint64_t fewest = share_of(target_, kLeastShareWithRoom);
    const bool is_bad = std::any_of(mesh_.tets.begin(), mesh_.tets.end(), [&](const Tet& tet) {
      const auto t = static_cast<Index>(&tet - mesh_.tets.data());
      return mesh_.is_alive(t) && flipper_.known_score(t) < kVeryBad;
    });
    if (!is_bad || mesh_.alive < fewest + kTetsOfASplit) return;
    collapse_last(mesh_.alive - kTetsOfASplit);
    repair(effort_.repair_rounds, effort_.compound_threshold, final_rule());
  }

  void collapse_to(std::uint64_t count) { collapse_with(kLeastScores, std::max(count, target_)); }

  /// The last few, strictly at first, unless collapses have ended far above the count: nothing strict is
  /// left.
  void collapse_last(std::uint64_t count) {
    if (!is_short()) collapse_with(kLastLeastScore, count);
    collapse_with(kLeastScores, count);
  }

  /// From here on neither repairs nor collapses leave a tet below the worst of now.
  void hold_floor() {
    floor_.emplace(scores_.far().ideal_volume);
    floor_->take(mesh_);
    repairer_.set_floor(&*floor_);
  }

  /// The count comes first: what no collapse above the floor reaches is collapsed anyway, and what that has
  /// left is the floor.
  void give_up_floor() {
    floor_.reset();
    collapse_last(target_);
    hold_floor();
  }

  void collapse_with(std::span<const double> least_scores, std::uint64_t count) {
    if (mesh_.alive <= count) return;
    CollapseOptions collapse;
    collapse.floor = floor_ ? &*floor_ : nullptr;
    collapse.placement = options_.collapse_placement;
    collapse.target = count;
    collapse.least_scores = least_scores;
    const CollapseReport report = collapse_edges(mesh_, scores_, collapse);
    collapses_.collapses += report.collapses;
    collapses_.rejected_link += report.rejected_link;
    collapses_.rejected_shape += report.rejected_shape;
  }

  void sweep(int steps) {
    if (options_.tools.smoothing) counts_.moves += smoother_.sweep(steps);
  }

  /// Edges alone: of six million faces on 27 skins none was worth a tet more. That is for repairs.
  void flip_below(double threshold) {
    if (!options_.tools.edge_removal) return;
    const auto end = static_cast<Index>(mesh_.tets.size());
    for (Index t = 0; t < end; ++t) {
      if (!mesh_.is_alive(t) || flipper_.known_score(t) >= threshold) continue;
      if (flipper_.try_edges_of(t)) ++counts_.edges_removed;
    }
  }

  void repair(int rounds, double compound_threshold, const FlipRule& rule) {
    repairer_.set_rule(rule);
    for (int i = 0; i < rounds; ++i) repairer_.round(effort_.repair_threshold, 0.0, effort_.final_steps + i);
    repairer_.round(compound_threshold, compound_threshold, kCompoundSteps);
  }

  FlipRule rule_of(double least_share, std::uint64_t most) const {
    FlipRule rule;
    rule.fewest_tets = share_of(target_, least_share) + 1;
    rule.most_tets = most;
    return rule;
  }

  /// For flips of a whole mesh.
  void set_window(double least_share, std::uint64_t most) {
    FlipRule rule = rule_of(least_share, most);
    rule.largest_ring = kLargestRingOfSweeps;
    flipper_.set_rule(rule);
  }

  WorkingMesh mesh_;
  const ScoreRule& scores_;
  const RefinedOptions& options_;
  const Effort effort_;
  const std::uint64_t target_;
  Smoother smoother_;
  Flipper flipper_;
  Repairer repairer_;
  std::optional<QualityFloor> floor_;  ///< with never_worse, in the repairs at the end
  CollapseReport collapses_;
  RepairCounts counts_;  ///< but those of the repairs
  StepCounts step_;
};

/// The working mesh that a run leaves; what else it held is released.
WorkingMesh reduce_mesh(WorkingMesh&& mesh, const ScoreRule& scores, const RefinedOptions& options,
                        std::uint64_t target, RefinedReport& report) {
  Run run(std::move(mesh), scores, options, target);
  run.simplify();
  report.collapses = run.collapses();
  report.counts = run.counts();
  return std::move(run.mesh());
}

/// The ideal volume of the far field, such that the wanted number of tets, graded by the field, fills the
/// mesh.
double ideal_volume(const TetMesh& mesh, const SizingField& field, std::uint64_t target) {
  return graded_volume(mesh, field) / static_cast<double>(std::max<std::uint64_t>(1, target));
}

}  // namespace

void validate_options(const RefinedOptions& options) {
  if (options.stop.fusions || (!options.stop.tets && !options.stop.ratio)) {
    throw InputError("stop", 0, "tets or ratio", options.stop.fusions ? "fusions" : "limit");
  }
  if (options.stop.ratio && !(*options.stop.ratio >= 0.0 && *options.stop.ratio < 1.0)) {
    throw InputError("ratio", 0, "a number in [0, 1)", std::to_string(*options.stop.ratio));
  }
  if (options.effort < 0 || options.effort > kMostEffort) {
    throw InputError("effort", 0, "0 to " + std::to_string(kMostEffort), std::to_string(options.effort));
  }
}

RefinedReport simplify_refined(TetMesh& mesh, const RefinedOptions& options) {
  validate_options(options);
  RefinedReport report;
  report.vertices_in = mesh.points.size();
  report.tets_in = mesh.tets.size();
  const std::uint64_t target = target_tet_count(options.stop, mesh.tets.size());
  const SizingField field(options.sizing, mesh);
  if (mesh.tets.size() > target) {
    const ScoreScale scale =
        scale_of_ideal_volume(ideal_volume(mesh, field, target), form_of(options.objective));
    const ScoreRule scores(scale, field);
    mesh = extract_mesh(
        reduce_mesh(build_working_mesh(std::move(mesh), field), scores, options, target, report));
  }
  report.vertices_out = mesh.points.size();
  report.tets_out = mesh.tets.size();
  report.stop = stop_or_limit(options.stop, target, report.tets_out);
  return report;
}

RefinedReport simplify_to_limit(TetMesh& mesh, const RefinedOptions& options) {
  validate_options(options);
  const std::uint64_t tets_in = mesh.tets.size();
  const std::uint64_t vertices_in = mesh.points.size();
  const std::size_t skin = build_unpaired_faces(mesh).size();
  const auto reduce = [&](TetMesh& body, std::uint64_t tets,
                          double abandon_beyond = std::numeric_limits<double>::infinity()) {
    RefinedOptions own = options;
    own.abandon_beyond = abandon_beyond;
    own.tools.insertions = false;  // each takes some six tets more
    own.stop = StopRule{};
    own.stop.tets = tets;
    return simplify_refined(body, own);
  };
  // A start that can be reached, so that the search below is on a small mesh.
  RefinedReport best = reduce(mesh, kSafeTetsPerFace * skin);
  const TetMesh start = mesh;
  // Runs from there to a count. What it leaves is kept if the count is reached or, if asked to, if it is less
  // than what is kept.
  const auto is_reached = [&](std::uint64_t wanted, bool keep_fewer) {
    TetMesh body = start;
    const auto most = static_cast<double>(std::max<std::uint64_t>(mesh.tets.size(), wanted));
    const RefinedReport found = reduce(body, wanted, kHopeless * most / static_cast<double>(wanted));
    const bool reached = found.stop != "limit";
    if (body.tets.size() < mesh.tets.size() && (reached || keep_fewer)) {
      mesh = std::move(body);
      best = found;
    }
    return reached;
  };
  const auto find_fewest = [&] {
    double reached = static_cast<double>(start.tets.size());
    double missed = static_cast<double>(skin) / kTetsPerFaceOfNone;
    while (kLimitResolution * missed < reached) {
      const double wanted = std::sqrt(missed * reached);
      (is_reached(static_cast<std::uint64_t>(wanted), true) ? reached : missed) = wanted;
    }
    // What can be reached has no sharp border: a few more below it.
    for (std::size_t misses = 0; misses < kBelowLimit.size();) {
      const std::size_t before = mesh.tets.size();
      is_reached(share_of(before, kBelowLimit[misses]), true);
      misses = mesh.tets.size() < before ? 0 : misses + 1;
    }
  };
  if (best.stop != "limit") {
    // A count that the way there has made impossible may be possible from here; if not, it plays no further
    // part.
    const std::uint64_t target = target_tet_count(options.stop, tets_in);
    if (target >= start.tets.size() || !is_reached(target, false)) find_fewest();
    best.stop = stop_or_limit(options.stop, target, mesh.tets.size());
  }
  best.tets_in = tets_in;
  best.vertices_in = vertices_in;
  return best;
}

}  // namespace palpate::simplify

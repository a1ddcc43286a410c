#include "tests/support/operation_fuzz/changing_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/orientation.h"
#include "core/mesh/topology.h"
#include "core/simplify/refined/repair.h"
#include "core/simplify/surface/surface.h"
#include "core/simplify/surface/surface_flip.h"
#include "core/simplify/surface/surface_smoothing.h"
#include "core/simplify/surface/surface_split.h"
#include "core/simplify/tet_operations/edge_collapse.h"
#include "tests/support/refined_checks.h"

namespace palpate::testing_support {

using simplify::Flipper;
using simplify::ScoreRule;
using simplify::Smoother;
using simplify::WorkingMesh;

struct ChangingMesh::Workshop {
  Workshop(TetMesh&& from, const simplify::SizingField& field, double mean_volume)
      : mesh(build_working_mesh(std::move(from), field)),
        scores(simplify::scale_of_ideal_volume(mean_volume), field),
        flipper(mesh, scores, {}),
        smoother(mesh, scores) {}

  WorkingMesh mesh;
  ScoreRule scores;
  Flipper flipper;
  Smoother smoother;
  simplify::VertexMarks marks;
};

namespace {

/// A tet that is alive, and wanted if one of those is found soon; kNoIndex if a few tries find none.
template <typename Mesh, typename IsWanted>
Index draw_tet(const Mesh& mesh, SplitMix64& random, const IsWanted& is_wanted) {
  constexpr int kTries = 16;
  Index found = kNoIndex;
  for (int i = 0; i < kTries; ++i) {
    const auto t = static_cast<Index>(random.below(mesh.tets.size()));
    if (!mesh.is_alive(t)) continue;
    found = t;
    if (is_wanted(t)) break;
  }
  return found;
}

/// A tet with something to change: one with a vertex inside.
Index draw_inner_tet(const WorkingMesh& mesh, SplitMix64& random) {
  return draw_tet(mesh, random, [&](Index t) {
    const Tet& tet = mesh.tets[t];
    return std::any_of(tet.begin(), tet.end(), [&](Index v) { return mesh.is_free(v); });
  });
}

bool is_positive(const WorkingMesh& mesh, const Tet& v) {
  return orientation(mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]], mesh.points[v[3]]) > 0;
}

bool is_star_positive(const WorkingMesh& mesh, Index v) {
  const auto star = mesh.star(v);
  return std::all_of(star.begin(), star.end(), [&](Index t) { return is_positive(mesh, mesh.tets[t]); });
}

/// Whether all tets that outlive the collapse stay positive. Leaves the mesh as it was.
bool is_collapse_positive(WorkingMesh& mesh, Index gone, Index survivor, const Vec3& to) {
  const Vec3 gone_was = mesh.points[gone];
  const Vec3 survivor_was = mesh.points[survivor];
  mesh.points[gone] = mesh.points[survivor] = to;
  bool is_good = true;
  for (const Index end : {gone, survivor}) {
    for (const Index t : mesh.star(end)) {
      const Tet& tet = mesh.tets[t];
      const Index other = end == gone ? survivor : gone;
      if (std::find(tet.begin(), tet.end(), other) == tet.end()) is_good = is_good && is_positive(mesh, tet);
    }
  }
  mesh.points[gone] = gone_was;
  mesh.points[survivor] = survivor_was;
  return is_good;
}

}  // namespace

ChangingMesh::ChangingMesh(TetMesh mesh, SplitMix64& random, Sabotage sabotage) : sabotage_(sabotage) {
  if (random.below(3) == 0) {
    const BoundingBox box = bounding_box(mesh.points);
    kept_ = simplify::KeptRegion{.center = mesh.points[random.below(mesh.points.size())],
                                 .radius = (0.05 + 0.15 * random.uniform()) * length(box.high - box.low)};
    sizing_.keep.push_back(*kept_);
    field_ = simplify::SizingField(sizing_, mesh);
  }
  mean_volume_ = total_volume(mesh) / static_cast<double>(mesh.tets.size()) * (0.5 + 2.0 * random.uniform());
  most_tets_ = 3 * mesh.tets.size();
  build(std::move(mesh));
}

ChangingMesh::~ChangingMesh() = default;

void ChangingMesh::build(TetMesh mesh) {
  shop_ = std::make_unique<Workshop>(std::move(mesh), field_, mean_volume_);
  can_undo_ = false;
}

TetMesh ChangingMesh::copy() const {
  return fusing_ ? extract_mesh(simplify::FusionMesh(*fusing_)) : copy_of(shop_->mesh);
}

bool ChangingMesh::rebuild() {
  TetMesh mesh = copy();
  can_undo_ = false;
  if (fusing_) {
    fusing_.reset();
    build(std::move(mesh));
    return true;
  }
  not_fused_ = build_boundary_vertex_flags(mesh);
  const auto kept = simplify::build_kept_vertices(simplify::build_kept_tets(field_, mesh), mesh);
  for (std::size_t v = 0; v < kept.size(); ++v) not_fused_[v] |= kept[v];
  if (sabotage_ == Sabotage::kFuseOnBoundary)
    std::fill(not_fused_.begin(), not_fused_.end(), std::uint8_t{0});
  fusing_ = build_fusion_mesh(std::move(mesh), simplify::StorageOrder::kSpatial);
  shop_.reset();
  return true;
}

bool ChangingMesh::perform(Operation operation, SplitMix64& random) {
  if (operation == Operation::kRebuild) return rebuild();
  if (operation == Operation::kFuse) return fuse(random);
  if (operation == Operation::kUndo) {
    if (!std::exchange(can_undo_, false)) return false;
    shop_->flipper.undo();
    return true;
  }
  if (operation <= Operation::kInsertVertex) {
    const bool has_flipped = flip(operation, random);
    can_undo_ = has_flipped && sabotage_ != Sabotage::kLoseTet && sabotage_ != Sabotage::kInsertUnseen;
    return has_flipped;
  }
  can_undo_ = false;
  if (operation == Operation::kSmooth) return smooth(random);
  if (operation == Operation::kMove) return move(random);
  if (operation == Operation::kCollapse) return collapse(random);
  return operation == Operation::kCollapseShortest ? collapse_shortest(random) : repair(random);
}

bool ChangingMesh::flip(Operation operation, SplitMix64& random) {
  WorkingMesh& mesh = shop_->mesh;
  const Index t = draw_tet(mesh, random, [](Index) { return true; });
  const auto& [i, j] = kTetEdges[random.below(6)];
  const std::uint64_t corner = random.below(4);
  // Bad flips too: what is wanted of them is only that they leave the mesh valid.
  const double growth = std::array{1e-6, -20.0, -1e300}[random.below(3)];
  if (t == kNoIndex) return false;
  const Index a = mesh.tets[t][static_cast<std::size_t>(i)];
  const Index b = mesh.tets[t][static_cast<std::size_t>(j)];
  Flipper& flipper = shop_->flipper;
  flipper.set_rule(
      {.least_growth = growth, .least_of_worst = random.below(2) == 0 ? 0.5 : 0.0, .most_tets = most_tets_});
  if (operation == Operation::kRemoveFace) return flipper.try_remove_face(t, corner);
  if (operation == Operation::kEdgesOfTet) return flipper.try_edges_of(t);
  if (operation == Operation::kSplitEdge) return flipper.split_edge(a, b) != kNoIndex;
  if (operation == Operation::kInsertVertex) return insert_vertex(t, random);
  if (!flipper.try_remove_edge(a, b)) return false;
  if (sabotage_ == Sabotage::kLoseTet) lose_tet(flipper.added().front());
  return true;
}

bool ChangingMesh::insert_vertex(Index tet, SplitMix64& random) {
  WorkingMesh& mesh = shop_->mesh;
  std::vector<Vec3> places;
  propose_places(mesh, tet, places);
  const Vec3 place = places[random.below(places.size())];
  const double least = std::array{0.005, 1e-4, 0.0}[random.below(3)];
  simplify::Cavity cavity(mesh, shop_->scores);
  if (sabotage_ == Sabotage::kInsertUnseen) {
    constexpr double kAny = -1e300;  // so that the tet alone gives way, wherever the place is
    if (!cavity.grow(tet, place, {kAny, kAny})) return false;
    const Index middle = add_vertex(mesh, place);
    std::vector<Tet> fresh;
    for (const auto& [a, b, c] : cavity.faces()) fresh.push_back({middle, a, b, c});
    std::vector<Index> added;
    apply_flip(mesh, cavity.tets(), fresh, added);
    return true;
  }
  return cavity.grow(tet, place, {least, random.below(2) == 0 ? least : 0.0}) &&
         shop_->flipper.insert_vertex(cavity.tets(), place, cavity.faces()) != kNoIndex;
}

void ChangingMesh::lose_tet(Index tet) {
  WorkingMesh& mesh = shop_->mesh;
  const Tet lost = mesh.tets[tet];
  if (std::any_of(lost.begin(), lost.end(), [&](Index v) { return mesh.star_size[v] < 2; })) return;
  std::vector<Index> added;
  apply_flip(mesh, {&tet, 1}, {}, added);
}

bool ChangingMesh::may_move(Index v) const {
  const std::uint8_t flags = shop_->mesh.vertex_flags[v];
  if (sabotage_ == Sabotage::kMoveOnBoundary && flags == simplify::kOnBoundary) return true;
  if (sabotage_ == Sabotage::kMoveKept && flags == simplify::kFrozen) return true;
  return flags == simplify::kFree;
}

bool ChangingMesh::smooth(SplitMix64& random) {
  WorkingMesh& mesh = shop_->mesh;
  const Index t = draw_inner_tet(mesh, random);
  if (t == kNoIndex) return false;
  const Index v = mesh.tets[t][random.below(4)];
  return mesh.is_free(v) && shop_->smoother.smooth(v, static_cast<int>(random.below(4))) > 0.0;
}

bool ChangingMesh::move(SplitMix64& random) {
  WorkingMesh& mesh = shop_->mesh;
  const Index t = draw_inner_tet(mesh, random);
  const std::uint64_t corner = random.below(4);
  const double share = random.uniform() * (random.below(2) == 0 ? 1.0 : 0.01);
  const Vec3 by{2.0 * random.uniform() - 1.0, 2.0 * random.uniform() - 1.0, 2.0 * random.uniform() - 1.0};
  if (t == kNoIndex) return false;
  const Index v = mesh.tets[t][corner];
  if (!may_move(v)) return false;
  const Vec3 from = mesh.points[v];
  const Vec3& other = mesh.points[mesh.tets[t][(corner + 1) % 4]];
  const Vec3 edge = other - from;
  // As far along each axis as the edge goes, so that flat stars are met too.
  apply_move(mesh, v, from + share * Vec3{by.x * edge.x, by.y * edge.y, by.z * edge.z});
  if (sabotage_ == Sabotage::kMoveUnchecked || is_star_positive(mesh, v)) return true;
  apply_move(mesh, v, from);
  return false;
}

bool ChangingMesh::collapse(SplitMix64& random) {
  WorkingMesh& mesh = shop_->mesh;
  const Index t = draw_inner_tet(mesh, random);
  const auto& [i, j] = kTetEdges[random.below(6)];
  const bool is_swapped = random.below(2) == 0;
  const double along = std::array{0.0, 0.5, 1.0}[random.below(3)];
  if (t == kNoIndex) return false;
  const Tet tet = mesh.tets[t];
  Index gone = tet[static_cast<std::size_t>(i)];
  Index survivor = tet[static_cast<std::size_t>(j)];
  if (is_swapped) std::swap(gone, survivor);
  const bool may_go = mesh.is_free(gone) || (sabotage_ == Sabotage::kCollapseOnBoundary &&
                                             mesh.vertex_flags[gone] == simplify::kOnBoundary);
  if (!may_go) return false;
  const Vec3 at = mesh.points[survivor];
  const Vec3 to = mesh.is_free(survivor) ? at + along * (mesh.points[gone] - at) : at;
  if (!meets_link_condition(mesh, gone, survivor, shop_->marks)) return false;
  if (sabotage_ != Sabotage::kCollapseUnchecked && !is_collapse_positive(mesh, gone, survivor, to))
    return false;
  apply_collapse(mesh, gone, survivor, to);
  return true;
}

/// Until a few tets are gone.
bool ChangingMesh::collapse_shortest(SplitMix64& random) {
  WorkingMesh& mesh = shop_->mesh;
  simplify::CollapseOptions options;
  const std::array least_scores{0.03, 0.0, -1.0};
  const std::size_t first = random.below(least_scores.size());
  options.least_scores =
      std::span(least_scores).subspan(first, 1 + random.below(least_scores.size() - first));
  options.placement = std::array{simplify::CollapsePlacement::kFirst, simplify::CollapsePlacement::kBest,
                                 simplify::CollapsePlacement::kMidpoint}[random.below(3)];
  options.target = mesh.alive - std::min<std::uint64_t>(mesh.alive, random.below(40));
  return collapse_edges(mesh, shop_->scores, options).collapses > 0;
}

bool ChangingMesh::repair(SplitMix64& random) {
  WorkingMesh& mesh = shop_->mesh;
  simplify::Repairer repairer(mesh, shop_->scores, {.most_tets = most_tets_}, {});
  const double threshold = 0.3 * random.uniform();
  if (random.below(2) == 0) repairer.set_manner(threshold);
  repairer.round(threshold, random.below(2) == 0 ? threshold : 0.0, static_cast<int>(random.below(4)));
  const simplify::RepairCounts& counts = repairer.counts();
  return counts.moves + counts.edges_removed + counts.faces_removed + counts.splits + counts.insertions > 0;
}

bool ChangingMesh::coarsen_skin(TetMesh& mesh, double bound, SplitMix64& random) {
  simplify::SurfaceOptions options;
  options.stop.ratio = 0.05 * random.uniform();
  options.effort = static_cast<int>(random.below(2));
  options.objective = std::array{simplify::Objective::kShape, simplify::Objective::kQuality,
                                 simplify::Objective::kStableStep}[random.below(3)];
  options.sizing = sizing_;
  options.max_surface_error = bound;
  try {
    simplify_surface(mesh, options);
  } catch (const InputError&) {
    return false;
  }
  return true;
}

bool ChangingMesh::pass_over_skin(TetMesh& mesh, double bound, SplitMix64& random) {
  WorkingMesh working = build_working_mesh(std::move(mesh), field_);
  simplify::GuardedBoundary boundary(working, bound);
  const ScoreRule scores(simplify::scale_of_ideal_volume(
                             mean_volume_, std::array{simplify::ScoreForm::kMeanRatio,
                                                      simplify::ScoreForm::kSolidAngle}[random.below(2)]),
                         field_);
  simplify::SurfaceReport report;
  const auto least_score = [&] { return std::array{0.03, 1e-9}[random.below(2)]; };
  for (std::uint64_t passes = 1 + random.below(4); passes > 0; --passes) {
    const std::uint64_t few = 2 * random.below(20);
    switch (random.below(5)) {
      case 0: {
        simplify::SurfaceSplitOptions options;
        options.least_score = least_score();
        options.face_target = boundary.size() + few;
        options.most_tets = most_tets_;
        report.splits += split_boundary_edges(working, boundary, scores, options);
        break;
      }
      case 1: {
        simplify::SurfaceCollapseOptions options;
        options.least_score = least_score();
        options.is_cure = random.below(2) == 0;
        options.face_target = boundary.size() - std::min<std::uint64_t>(boundary.size(), few);
        collapse_boundary_edges(working, boundary, scores, options, report);
        break;
      }
      case 2: {
        const auto aim = std::array{simplify::FlipAim::kSum, simplify::FlipAim::kWorst}[random.below(2)];
        report.flips += simplify::BoundaryFlipper(working, boundary, scores, aim).pass(0.3);
        break;
      }
      case 3: {
        if (random.below(2) == 0)
          smooth_boundary(working, boundary, scores, boundary.volume(working), report);
        else
          mend_boundary(working, boundary, scores, report);
        break;
      }
      default: {
        simplify::StepSkinMoves moves(working, boundary, report);
        simplify::StepLengthener(working, scores, {.most_tets = most_tets_}, &moves).run(1);
      }
    }
  }
  mesh = extract_mesh(std::move(working));
  return report.splits + report.collapses + report.flips + report.moves > 0;
}

std::optional<double> ChangingMesh::change_skin(SplitMix64& random) {
  TetMesh mesh = copy();
  const BoundingBox box = bounding_box(mesh.points);
  const double bound = 0.02 * random.uniform() * length(box.high - box.low);
  const double held = sabotage_ == Sabotage::kSkinStrays ? 10.0 * bound : bound;
  const bool has_changed =
      random.below(2) == 0 ? coarsen_skin(mesh, held, random) : pass_over_skin(mesh, held, random);
  if (!has_changed) return std::nullopt;
  build(std::move(mesh));
  return bound;
}

/// One tet to its barycenter, if no tet around turns over.
bool ChangingMesh::fuse(SplitMix64& random) {
  simplify::FusionMesh& mesh = *fusing_;
  const Index t = draw_tet(mesh, random, [&](Index i) { return !has_flagged_vertex(mesh, i, not_fused_); });
  if (t == kNoIndex || has_flagged_vertex(mesh, t, not_fused_)) return false;
  plan_fusion(mesh, t, plan_);
  for (const simplify::MovedTet& m : plan_.moved) {
    const auto p = moved_points(mesh, plan_, m);
    if (orientation(p[0], p[1], p[2], p[3]) <= 0) return false;
  }
  apply_fusion(mesh, plan_);
  return true;
}

}  // namespace palpate::testing_support

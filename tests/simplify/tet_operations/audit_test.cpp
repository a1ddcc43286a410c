// The audit: all own simplifiers on all kinds of meshes, with options and stops at random, and the judge's
// full check of what is left at that moment.
//
// In the test suite it goes on for some thousand operations. By hand, a million:
//   PALPATE_AUDIT_OPERATIONS=1000000 build/release/bin/palpate_tests --gtest_filter='Audit.*'
// PALPATE_AUDIT_SEED starts it elsewhere; the seed of each step is in the message if one fails.
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <map>
#include <set>
#include <span>
#include <string>

#include "core/base/error.h"
#include "core/judge/mesh/judge.h"
#include "core/judge/surface/feature_distance.h"
#include "core/judge/surface/surface.h"
#include "core/mesh/geometry.h"
#include "core/mesh/orientation.h"
#include "core/mesh/shapes/shapes.h"
#include "core/simplify/fusion/cheapest_first.h"
#include "core/simplify/fusion/hierarchical.h"
#include "core/simplify/refined/refined.h"
#include "core/simplify/surface/surface.h"
#include "core/simplify/tet_operations/flips.h"
#include "core/simplify/tet_operations/smoothing.h"
#include "tests/support/full_mode.h"
#include "tests/support/hard_meshes.h"

namespace palpate::simplify {
namespace {

using testing_support::HardMesh;

/// What was done to meshes.
struct Operations {
  std::uint64_t fusions = 0;
  std::uint64_t collapses = 0;
  std::uint64_t flips = 0;
  std::uint64_t moves = 0;
  std::uint64_t checks = 0;
  std::uint64_t refusals = 0;

  std::uint64_t changes() const { return fusions + collapses + flips; }
};

void print(const char* what, const Operations& o) {
  std::cout << what << ": " << o.fusions << " fusions, " << o.collapses << " collapses, " << o.flips
            << " flips, " << o.moves << " moves, " << o.refusals << " refusals; " << o.checks
            << " full checks\n";
}

std::uint64_t number_from(const char* variable, std::uint64_t fallback) {
  const char* text = std::getenv(variable);
  return text == nullptr ? fallback : std::strtoull(text, nullptr, 10);
}

std::uint64_t wanted_operations() {
  return number_from("PALPATE_AUDIT_OPERATIONS", 60'000);
}

enum class Method { kHierarchical, kOutcome, kRefined, kSurface };
constexpr std::array kMethods{Method::kHierarchical, Method::kOutcome, Method::kRefined, Method::kSurface};
constexpr std::array kMethodNames{"hierarchical", "outcome", "refined", "surface"};

const char* name_of(Method method) {
  return kMethodNames[static_cast<std::size_t>(method)];
}

/// Holds an output against its input with the judge.
void expect_sound(const TetMesh& output, const TetMesh& input, bool same_boundary) {
  const judge::Validity validity = judge::check_validity(output);
  EXPECT_TRUE(validity.is_valid()) << (validity.findings.empty() ? "" : validity.findings.front());
  const judge::Comparison comparison = judge::compare_with_input(output, input);
  EXPECT_TRUE(comparison.euler_unchanged);
  EXPECT_TRUE(comparison.components_unchanged);
  if (same_boundary) {
    EXPECT_EQ(comparison.boundary_changed_faces, 0U);
    // The same body: n volumes, each rounded to some 2^-50 of the largest product in it.
    EXPECT_LE(comparison.volume_drift_relative, 1e-9);
  } else if (judge::count_self_intersections(judge::build_boundary(input)) == 0) {
    EXPECT_EQ(judge::count_self_intersections(judge::build_boundary(output)), 0U);
  }
}

/// The input's sharp edges, by the judge, are within the bound of edges of the output, and where three or
/// more meet, or one ends, there is a vertex still.
void expect_lines(const TetMesh& output, const TetMesh& input, const SurfaceOptions& options,
                  double diagonal) {
  const SurfaceMesh skin = judge::build_boundary(input);
  const auto sharp = judge::list_sharp_edges(skin, options.feature_deg);
  const auto all = judge::list_sharp_edges(judge::build_boundary(output), -1.0);
  EXPECT_LE(judge::measure_edge_distance(sharp, all).lower, options.max_surface_error + 1e-12 * diagonal);
  using Place = std::array<double, 3>;
  const auto place = [](const Vec3& p) { return Place{p.x, p.y, p.z}; };
  std::map<Place, int> edges_at;
  for (const auto& [a, b] : sharp) {
    ++edges_at[place(a)];
    ++edges_at[place(b)];
  }
  std::set<Place> left;
  for (const Vec3& p : output.points) left.insert(place(p));
  for (const auto& [at, edges] : edges_at) EXPECT_TRUE(edges == 2 || left.contains(at));
}

SizingOptions random_sizing(const TetMesh& mesh, SplitMix64& random) {
  SizingOptions sizing;
  if (random.below(4) == 0) {
    std::vector<double> sizes(mesh.points.size());
    for (double& size : sizes) size = 0.2 + random.uniform();
    sizing.sizes = make_size_grid(mesh, sizes);
  }
  if (random.below(3) != 0) return sizing;
  const Vec3 center = mesh.points[random.below(mesh.points.size())];
  const BoundingBox box = bounding_box(mesh.points);
  const double size = length(box.high - box.low);
  sizing.keep.push_back({.center = center, .radius = (0.05 + 0.15 * random.uniform()) * size});
  sizing.near_size = 0.3 + 0.7 * random.uniform();
  return sizing;
}

StopRule random_stop(SplitMix64& random) {
  StopRule stop;
  stop.ratio = random.uniform() * (random.below(2) == 0 ? 0.5 : 0.99);
  return stop;
}

void run_fusions(Method method, TetMesh& mesh, const SizingOptions& sizing, SplitMix64& random,
                 Operations& done) {
  CheapestFirstOptions options;
  SimplifyOptions& common = options.common;
  if (method == Method::kHierarchical) common = {};
  common.stop = random_stop(random);
  common.sizing = sizing;
  common.drop = std::array{0.0, 0.01, 0.5}[random.below(3)];
  common.last_level = static_cast<int>(1 + random.below(2));
  common.skip_touched = random.below(2) == 0;
  common.levels =
      std::array{LevelAdjacency::kVertex, LevelAdjacency::kEdge, LevelAdjacency::kFace}[random.below(3)];
  common.metric = random.below(3) == 0 ? kMeanRatioMetric : kThesisMetric;
  common.threads = static_cast<int>(1 + random.below(2));
  if (method == Method::kHierarchical) {
    if (random.below(3) == 0) common.ideal_volume = IdealVolume::kUpdated;
    done.fusions += simplify_hierarchical(mesh, common).fusions;
  } else {
    if (random.below(2) == 0) options.objective = CostObjective::kTotalLoss;
    done.fusions += simplify_cheapest_first(mesh, options).fusions;
  }
}

void run_refined(TetMesh& mesh, const SizingOptions& sizing, SplitMix64& random, Operations& done) {
  RefinedOptions options;
  if (random.below(2) == 0) options.objective = Objective::kQuality;
  options.stop = random_stop(random);
  options.sizing = sizing;
  options.effort = static_cast<int>(random.below(3));
  const RefinedReport report = simplify_refined(mesh, options);
  done.collapses += report.collapses.collapses;
  done.flips += report.counts.edges_removed + report.counts.faces_removed + report.counts.splits +
                report.counts.insertions;
  done.moves += report.counts.moves;
}

void run_surface(TetMesh& mesh, const SizingOptions& sizing, SplitMix64& random, Operations& done) {
  SurfaceOptions options;
  options.stop = random_stop(random);
  options.sizing = sizing;
  options.effort = static_cast<int>(random.below(2));
  const BoundingBox box = bounding_box(mesh.points);
  const double diagonal = length(box.high - box.low);
  options.max_surface_error = 0.05 * random.uniform() * diagonal;
  if (random.below(2) == 0) options.feature_deg = 20.0 + 80.0 * random.uniform();
  const TetMesh input = options.feature_deg > 0.0 ? mesh : TetMesh();
  const SurfaceRunReport report = simplify_surface(mesh, options);
  if (options.feature_deg > 0.0) expect_lines(mesh, input, options, diagonal);
  done.collapses += report.surface.collapses + report.inner.collapses;
  done.flips += report.surface.flips;
  done.moves += report.surface.moves;
}

void run_method(Method method, TetMesh& mesh, const SizingOptions& sizing, SplitMix64& random,
                Operations& done) {
  if (method == Method::kRefined) {
    run_refined(mesh, sizing, random, done);
  } else if (method == Method::kSurface) {
    run_surface(mesh, sizing, random, done);
  } else {
    run_fusions(method, mesh, sizing, random, done);
  }
}

/// Runs a method with options at random, and has the judge look at the result. A refusal in one line is an
/// answer too.
void run_and_check(Method method, const TetMesh& input, std::uint64_t seed, Operations& done) {
  SplitMix64 random(seed);
  const SizingOptions sizing = random_sizing(input, random);
  TetMesh mesh = input;
  try {
    run_method(method, mesh, sizing, random, done);
  } catch (const InputError& error) {
    const std::string message = error.what();
    EXPECT_FALSE(message.empty());
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    ++done.refusals;
    return;
  }
  expect_sound(mesh, input, method != Method::kSurface);
  if (!sizing.keep.empty()) {
    const judge::Region region{judge::Region::Kind::kSphere, sizing.keep[0].center, sizing.keep[0].radius,
                               0.0};
    EXPECT_EQ(judge::compare_in_regions(mesh, input, {&region, 1}).changed_tets, 0U);
  }
  ++done.checks;
}

std::vector<HardMesh> small_hard_meshes(std::uint64_t seed) {
  auto all = testing_support::list_hard_meshes(seed);
  all.push_back({"jittered cube", build_kuhn_cube(10, 0.4, seed)});
  return all;
}

TEST(Audit, TheHardMeshesAreValid) {
  for (const HardMesh& hard : small_hard_meshes(1)) {
    const judge::Validity validity = judge::check_validity(hard.mesh);
    EXPECT_TRUE(validity.is_valid()) << hard.name << ": "
                                     << (validity.findings.empty() ? "" : validity.findings.front());
  }
  EXPECT_EQ(judge::count_elements(testing_support::make_three_holes(2, 1)).euler, -2);
  EXPECT_EQ(judge::count_elements(testing_support::make_divided_hollow(2, 1)).euler, 2);
  EXPECT_EQ(judge::count_elements(testing_support::make_three_parts(2, 1)).components, 3U);
}

TEST(Audit, EveryMethodOnEveryHardMeshEndsValidOrRefuses) {
  const std::uint64_t seed = number_from("PALPATE_AUDIT_SEED", 1);
  Operations done;
  for (const HardMesh& hard : small_hard_meshes(seed)) {
    for (const Method method : kMethods) {
      for (std::uint64_t run = 0; run < static_cast<std::uint64_t>(test::full_or(3, 1)); ++run) {
        SCOPED_TRACE(std::string(name_of(method)) + " on " + hard.name + ", seed " +
                     std::to_string(seed + run));
        run_and_check(method, hard.mesh, seed + run, done);
        if (HasFailure()) return;
      }
    }
  }
  print("hard meshes", done);
  EXPECT_GT(done.fusions, 0U);
  EXPECT_GT(done.collapses, 0U);
  EXPECT_GT(done.flips, 0U);
}

TEST(Audit, EveryMethodRefusesWhatIsNoMeshOfABody) {
  TetMesh three_at_a_face = testing_support::make_two_tets();
  three_at_a_face.points.push_back({1, 1, 1});
  three_at_a_face.tets.push_back({0, 1, 2, 5});
  TetMesh folded = testing_support::make_two_tets();
  folded.points[4] = {0.1, 0.1, 0.5};
  std::swap(folded.tets[1][1], folded.tets[1][2]);
  for (const TetMesh& mesh : {three_at_a_face, folded}) {
    for (const Method method : kMethods) {
      Operations done;
      run_and_check(method, mesh, 1, done);
      EXPECT_EQ(done.refusals, 1U) << name_of(method);
    }
  }
}

TEST(Audit, EveryMethodLeavesNothingOfNothing) {
  for (const Method method : kMethods) {
    Operations done;
    TetMesh mesh;
    SplitMix64 random(2);
    try {
      run_method(method, mesh, {}, random, done);
    } catch (const InputError&) {
      continue;  // a refusal is as good
    }
    EXPECT_EQ(mesh, TetMesh()) << name_of(method);
    EXPECT_EQ(done.changes(), 0U) << name_of(method);
  }
}

/// Whole runs of the methods, on ever new meshes.
TEST(Audit, RunsThatStopAtRandomLeaveValidMeshes) {
  const std::uint64_t start = number_from("PALPATE_AUDIT_SEED", 1);
  Operations done;
  for (std::uint64_t seed = start; done.changes() < wanted_operations() / 2; ++seed) {
    SplitMix64 random(seed);
    const auto meshes = small_hard_meshes(seed);
    for (std::uint64_t run = 0; run < 8; ++run) {
      const HardMesh& hard = meshes[random.below(meshes.size())];
      const Method method = kMethods[random.below(kMethods.size())];
      const std::uint64_t own = random.next();
      SCOPED_TRACE(std::string(name_of(method)) + " on " + hard.name + " of seed " + std::to_string(seed) +
                   ", run " + std::to_string(own));
      run_and_check(method, hard.mesh, own, done);
      if (HasFailure()) return;
    }
  }
  print("runs", done);
}

/// Fuses t if no vertex of it is on the boundary and no moved tet would turn over. Returns whether it did.
bool fuse_if_positive(FusionMesh& mesh, Index t, const std::vector<std::uint8_t>& is_boundary,
                      FusionPlan& plan) {
  if (!mesh.is_alive(t) || has_flagged_vertex(mesh, t, is_boundary)) return false;
  plan_fusion(mesh, t, plan);
  for (const MovedTet& m : plan.moved) {
    const auto p = moved_points(mesh, plan, m);
    if (orientation(p[0], p[1], p[2], p[3]) <= 0) return false;
  }
  apply_fusion(mesh, plan);
  return true;
}

TEST(Audit, FusionsInAnyOrderKeepTheMeshValid) {
  const std::uint64_t start = number_from("PALPATE_AUDIT_SEED", 1);
  Operations done;
  for (std::uint64_t seed = start; done.changes() < wanted_operations() / 4; ++seed) {
    SplitMix64 random(seed);
    const auto meshes = small_hard_meshes(seed);
    const bool is_large = random.below(2) == 0;
    const TetMesh input = is_large ? build_kuhn_cube(static_cast<int>(12 + random.below(10)), 0.4, seed)
                                   : meshes[random.below(meshes.size())].mesh;
    SCOPED_TRACE("seed " + std::to_string(seed));
    const std::vector<std::uint8_t> is_boundary = build_boundary_vertex_flags(input);
    FusionMesh mesh =
        build_fusion_mesh(TetMesh(input), is_large ? StorageOrder::kSpatial : StorageOrder::kInput);
    FusionPlan plan;
    for (std::size_t i = 0; i < 2 * input.tets.size(); ++i) {
      const auto t = static_cast<Index>(random.below(mesh.tets.size()));
      done.fusions += fuse_if_positive(mesh, t, is_boundary, plan) ? 1U : 0U;
      if (random.below(input.tets.size()) != 0 && i + 1 < 2 * input.tets.size()) continue;
      expect_sound(extract_mesh(FusionMesh(mesh)), input, true);
      ++done.checks;
    }
    if (HasFailure()) return;
  }
  print("single fusions", done);
}

/// One operation on a tet at random, if it can be done.
void change_something(WorkingMesh& mesh, Flipper& flipper, Smoother& smoother, SplitMix64& random,
                      Operations& done) {
  const auto t = static_cast<Index>(random.below(mesh.tets.size()));
  if (!mesh.is_alive(t)) return;
  const Tet tet = mesh.tets[t];
  const auto& [i, j] = kTetEdges[random.below(6)];
  const Index a = tet[static_cast<std::size_t>(i)];
  const Index b = tet[static_cast<std::size_t>(j)];
  bool has_flipped = false;
  switch (random.below(5)) {
    case 0:
      has_flipped = flipper.try_remove_edge(a, b);
      break;
    case 1:
      has_flipped = flipper.try_remove_face(t, random.below(4));
      break;
    case 2:
      has_flipped = flipper.try_edges_of(t);
      break;
    case 3:
      has_flipped = random.below(8) == 0 && flipper.split_edge(a, b) != kNoIndex;
      break;
    default:
      if (mesh.is_free(tet[0])) done.moves += smoother.smooth(tet[0], 2) > 0.0 ? 1U : 0U;
  }
  if (!has_flipped) return;
  ++done.flips;
  if (random.below(4) != 0) return;
  flipper.undo();
  ++done.flips;
}

/// Single operations in any order, as no method would do them.
TEST(Audit, OperationsInAnyOrderKeepTheMeshValid) {
  const std::uint64_t start = number_from("PALPATE_AUDIT_SEED", 1);
  Operations done;
  for (std::uint64_t seed = start; done.changes() < wanted_operations() / 4; ++seed) {
    SplitMix64 random(seed);
    const auto meshes = small_hard_meshes(seed);
    const HardMesh& hard = meshes[random.below(meshes.size())];
    SCOPED_TRACE(hard.name + " of seed " + std::to_string(seed));
    const SizingField field;
    WorkingMesh mesh = build_working_mesh(TetMesh(hard.mesh), field);
    const double mean_volume = total_volume(hard.mesh) / static_cast<double>(hard.mesh.tets.size());
    const ScoreForm form = random.below(2) == 0 ? ScoreForm::kSolidAngle : ScoreForm::kMeanRatio;
    ScoreScale scale = scale_of_ideal_volume(mean_volume * (0.5 + 2.0 * random.uniform()), form);
    scale.dihedral_weight = random.below(2) == 0 ? 0.5 : 1e3;
    const ScoreRule scores(scale, field);
    Flipper flipper(mesh, scores, {});
    Smoother smoother(mesh, scores);
    for (int round = 0; round < 4; ++round) {
      // Bad flips too: what is wanted of them is only that they leave the mesh valid.
      const double growth = std::array{1e-6, -20.0 * random.uniform(), -1e300}[random.below(3)];
      flipper.set_rule({.least_growth = growth, .least_of_worst = random.below(2) == 0 ? 0.5 : 0.0});
      for (std::size_t i = 0; i < 2 * hard.mesh.tets.size(); ++i) {
        change_something(mesh, flipper, smoother, random, done);
        if (random.below(hard.mesh.tets.size()) != 0) continue;
        expect_sound(extract_mesh(WorkingMesh(mesh)), hard.mesh, true);
        ++done.checks;
      }
      CollapseOptions collapse;
      const std::array least_scores{0.03, 0.003, 0.0, -1.0};
      const std::size_t first = random.below(least_scores.size());
      collapse.least_scores =
          std::span(least_scores).subspan(first, 1 + random.below(least_scores.size() - first));
      collapse.placement = std::array{CollapsePlacement::kFirst, CollapsePlacement::kBest,
                                      CollapsePlacement::kMidpoint}[random.below(3)];
      collapse.target =
          static_cast<std::uint64_t>(static_cast<double>(mesh.alive) * (0.7 + 0.3 * random.uniform()));
      done.collapses += collapse_edges(mesh, scores, collapse).collapses;
      expect_sound(extract_mesh(WorkingMesh(mesh)), hard.mesh, true);
      ++done.checks;
      if (HasFailure()) return;
    }
  }
  print("single operations", done);
}

}  // namespace
}  // namespace palpate::simplify

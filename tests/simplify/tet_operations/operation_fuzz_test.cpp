// Fuzzing of the operations on meshes: fusions, collapses, flips, moves, repairs, and coarsening, collapses,
// splits, flips and moves of the skin, one after another in any order, on bodies drawn at random, with the
// judge as the oracle. The audit beside it runs whole methods, and operations of one kind; here each sequence
// is replayed by a seed and a number, and a fault is made as short as it can be:
//   PALPATE_OPERATIONS_SEED=7 PALPATE_OPERATIONS=912 build/release/bin/palpate_tests
//   --gtest_filter=OperationFuzz.Replay
// Longer, from another seed on:
//   PALPATE_OPERATIONS_TOTAL=20000000 PALPATE_OPERATIONS_SEED=1000 build/release/bin/palpate_tests
//     --gtest_filter=OperationFuzz.AnyOrder*
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <numeric>
#include <set>
#include <string>

#include "core/judge/mesh/judge.h"
#include "core/mesh/shapes/body_surfaces.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/full_mode.h"
#include "tests/support/operation_fuzz/operation_sequence.h"
#include "tests/support/operation_fuzz/random_body.h"

namespace palpate::testing_support {
namespace {

constexpr std::uint64_t kOperationsPerSequence = 2000;

/// Of the environment, or `fallback`.
std::uint64_t wanted(const char* variable, std::uint64_t fallback) {
  const char* text = std::getenv(variable);
  return text == nullptr ? fallback : std::strtoull(text, nullptr, 10);
}

TEST(OperationFuzz, BodiesAreValidAndOfEveryTopology) {
  std::set<std::string> names;
  std::set<std::int64_t> euler;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const RandomBody body = make_random_body(seed);
    const judge::Validity validity = judge::check_validity(body.mesh);
    EXPECT_TRUE(validity.is_valid()) << body.name << ", seed " << seed << ": "
                                     << (validity.findings.empty() ? "" : validity.findings.front());
    const judge::Counts counts = judge::count_elements(body.mesh);
    EXPECT_EQ(counts.components, 1U) << seed;
    names.insert(body.name);
    euler.insert(counts.euler);
  }
  EXPECT_EQ(names.size(), 6U);
  EXPECT_LT(*euler.begin(), 1) << "a handle";
  EXPECT_GT(*euler.rbegin(), 1) << "a cavity";
}

TEST(OperationFuzz, ShellsAreFineAtTheSkinAndMayBeHollow) {
  const SurfaceMesh skin = build_lobes_surface(4);
  for (const bool is_hollow : {false, true}) {
    const TetMesh mesh = make_shells(skin, 2, 0.5, is_hollow);
    EXPECT_TRUE(judge::check_validity(mesh).is_valid());
    const judge::Counts counts = judge::count_elements(mesh);
    EXPECT_EQ(counts.euler, is_hollow ? 2 : 1);
    EXPECT_EQ(counts.boundary_faces, (is_hollow ? 2 : 1) * skin.triangles.size());
  }
}

/// Sequences on ever new bodies.
TEST(OperationFuzz, AnyOrderKeepsWhatIsPromised) {
  const std::uint64_t first = wanted("PALPATE_OPERATIONS_SEED", 1);
  const auto quick = static_cast<std::uint64_t>(test::full_or(3'000'000, 50'000));
  const std::uint64_t total = wanted("PALPATE_OPERATIONS_TOTAL", quick);
  std::array<std::uint64_t, kOperations> changed{};
  std::uint64_t checks = 0;
  std::uint64_t kept = 0;
  std::uint64_t done = 0;
  for (std::uint64_t seed = first; done < total; ++seed, done += kOperationsPerSequence) {
    const SequenceOptions options{seed, kOperationsPerSequence, 200, Sabotage::kNone};
    const SequenceResult result = run_sequence(options);
    if (result.fault) {
      SequenceOptions failing = options;
      failing.operations = result.fault->operations;
      FAIL() << describe_fault(options, result, minimise(failing));
    }
    for (std::size_t i = 0; i < kOperations; ++i) changed[i] += result.changed[i];
    checks += result.checks;
    kept += result.has_kept_region ? 1U : 0U;
  }
  std::cout << done << " operations tried, "
            << std::accumulate(changed.begin(), changed.end(), std::uint64_t{0}) << " made, " << checks
            << " checks:";
  for (std::size_t i = 0; i < kOperations; ++i) {
    std::cout << ' ' << operation_name(static_cast<Operation>(i)) << ' ' << changed[i];
    EXPECT_GT(changed[i], 0U) << operation_name(static_cast<Operation>(i));
  }
  std::cout << '\n';
  EXPECT_GT(kept, 0U);
}

/// What a failure's message asks for. Without it: a short sequence, twice the same.
TEST(OperationFuzz, Replay) {
  SequenceOptions options{wanted("PALPATE_OPERATIONS_SEED", 3), wanted("PALPATE_OPERATIONS", 1000), 0,
                          Sabotage::kNone};
  const SequenceResult result = run_sequence(options);
  if (result.fault) FAIL() << describe_fault(options, result, *result.fault);
  options.check_every = 7;  // looking at a mesh does not change what follows
  const SequenceResult again = run_sequence(options);
  EXPECT_EQ(result.changed, again.changed);
  EXPECT_GT(again.checks, result.checks);
}

struct Broken {
  Sabotage sabotage;
  std::set<Operation> last;  ///< what the shortest failing sequence ends with
  std::uint64_t check_every;
};

/// The judge notices an operation that is broken, and the shortest sequence ends with that one.
TEST(OperationFuzz, AnOperationThatIsBrokenOnPurposeIsCaughtAndCutDown) {
  const std::array<Broken, 9> all{{
      {Sabotage::kMoveUnchecked, {Operation::kMove}, 100},
      {Sabotage::kMoveOnBoundary, {Operation::kMove}, 100},
      {Sabotage::kMoveKept, {Operation::kMove}, 100},
      {Sabotage::kCollapseUnchecked, {Operation::kCollapse}, 100},
      {Sabotage::kCollapseOnBoundary, {Operation::kCollapse}, 100},
      {Sabotage::kFuseOnBoundary, {Operation::kFuse}, 100},
      {Sabotage::kInsertUnseen, {Operation::kInsertVertex}, 100},
      {Sabotage::kLoseTet, {Operation::kRemoveEdge}, 20},
      {Sabotage::kSkinStrays, {Operation::kSkin}, 100},
  }};
  for (const Broken& broken : all) {
    SCOPED_TRACE("sabotage " + std::to_string(static_cast<int>(broken.sabotage)));
    SequenceOptions options{1, 3000, broken.check_every, broken.sabotage};
    SequenceResult result = run_sequence(options);
    for (; !result.fault && options.seed < 40; result = run_sequence(options)) ++options.seed;
    ASSERT_TRUE(result.fault.has_value());
    std::cout << operation_name(*broken.last.begin()) << ": seed " << options.seed << ", seen after "
              << result.fault->operations;
    options.operations = result.fault->operations;
    const SequenceFault least = minimise(options);
    std::cout << ", cut down to " << least.operations << ": " << least.what << '\n';
    EXPECT_LE(least.operations, options.operations);
    EXPECT_TRUE(broken.last.contains(least.last)) << operation_name(least.last) << ": " << least.what;
    options.check_every = 0;
    options.operations = least.operations;
    EXPECT_TRUE(run_sequence(options).fault.has_value());
    --options.operations;
    EXPECT_FALSE(run_sequence(options).fault.has_value()) << "one operation fewer";
    SequenceOptions whole = options;
    whole.operations = least.operations;
    whole.sabotage = Sabotage::kNone;
    EXPECT_FALSE(run_sequence(whole).fault.has_value()) << "unbroken, the same sequence is sound";
    EXPECT_NE(
        describe_fault(whole, result, least).find("PALPATE_OPERATIONS_SEED=" + std::to_string(whole.seed)),
        std::string::npos);
  }
}

}  // namespace
}  // namespace palpate::testing_support

#include "tests/support/operation_fuzz/operation_sequence.h"

#include <exception>
#include <numeric>
#include <utility>

#include "core/base/error.h"
#include "core/judge/mesh/judge.h"
#include "core/judge/surface/surface.h"
#include "tests/support/operation_fuzz/changing_mesh.h"
#include "tests/support/operation_fuzz/random_body.h"

namespace palpate::testing_support {
namespace {

constexpr std::array<const char*, kOperations> kNames{
    "remove edge", "remove face", "edges of a tet",    "split edge", "insert vertex", "undo", "smooth",
    "move",        "collapse",    "collapse shortest", "repair",     "skin",          "fuse", "rebuild"};

/// How often each is drawn, a share of the sum; fusions have a mesh and a turn of their own.
constexpr std::array<std::uint64_t, kOperations> kWeight{320, 260, 260, 240, 60, 80, 260,
                                                         260, 180, 8,   4,   6,  0,  10};

constexpr std::uint64_t kWeights = std::accumulate(kWeight.begin(), kWeight.end(), std::uint64_t{0});

Operation draw(SplitMix64& random, bool is_fusing) {
  if (is_fusing) return random.below(200) == 0 ? Operation::kRebuild : Operation::kFuse;
  std::uint64_t at = random.below(kWeights);
  std::size_t i = 0;
  while (at >= kWeight[i]) at -= kWeight[i++];
  return static_cast<Operation>(i);
}

std::optional<std::string> find_kept_fault(const TetMesh& mesh, const TetMesh& input,
                                           const ChangingMesh& changing) {
  const auto& kept = changing.kept();
  if (!kept) return std::nullopt;
  const judge::Region region{judge::Region::Kind::kSphere, kept->center, kept->radius, 0.0};
  const std::uint64_t changed = judge::compare_in_regions(mesh, input, {&region, 1}).changed_tets;
  if (changed == 0) return std::nullopt;
  return std::to_string(changed) + " kept tets changed";
}

std::optional<std::string> find_fault(const TetMesh& mesh, const TetMesh& input,
                                      const ChangingMesh& changing) {
  const judge::Validity validity = judge::check_validity(mesh);
  if (!validity.is_valid()) return validity.findings.empty() ? "not valid" : validity.findings.front();
  const judge::Comparison comparison = judge::compare_with_input(mesh, input);
  if (!comparison.euler_unchanged) return "another Euler characteristic";
  if (!comparison.components_unchanged) return "another number of parts";
  if (comparison.boundary_changed_faces > 0)
    return std::to_string(comparison.boundary_changed_faces) + " boundary faces changed";
  // The same body: n volumes, each rounded to some 2^-50 of the largest product in it.
  if (!(comparison.volume_drift_relative <= 1e-9)) return "another volume";
  return find_kept_fault(mesh, input, changing);
}

/// What palpate.surface may not do: it may change the skin within a bound, and so the mesh that is compared
/// with.
std::optional<std::string> find_skin_fault(const TetMesh& mesh, const TetMesh& before, double bound,
                                           const ChangingMesh& changing) {
  const judge::Comparison comparison = judge::compare_with_input(mesh, before);
  if (!comparison.euler_unchanged || !comparison.components_unchanged) return "another topology of the skin";
  const SurfaceMesh skin = judge::build_boundary(mesh);
  const SurfaceMesh skin_before = judge::build_boundary(before);
  if (judge::count_self_intersections(skin_before) == 0 && judge::count_self_intersections(skin) > 0)
    return "a skin that meets itself";
  const judge::SurfaceDistance distance = judge::measure_surface_distance(skin, skin_before);
  const double rounding = 1e-12 * distance.diagonal;
  if (!(distance.lower() <= bound + rounding))
    return "a skin " + std::to_string(distance.lower()) + " off, its bound is " + std::to_string(bound);
  return find_kept_fault(mesh, before, changing);
}

/// One operation; what is wrong already, where only the moment tells.
std::optional<std::string> perform(Operation operation, ChangingMesh& mesh, SplitMix64& random,
                                   TetMesh& input, SequenceResult& result) {
  if (operation != Operation::kSkin) {
    result.changed[static_cast<std::size_t>(operation)] += mesh.perform(operation, random) ? 1U : 0U;
    return std::nullopt;
  }
  const TetMesh before = mesh.copy();
  const std::optional<double> bound = mesh.change_skin(random);
  if (!bound) return std::nullopt;
  ++result.changed[static_cast<std::size_t>(operation)];
  const TetMesh after = mesh.copy();
  if (auto what = find_fault(before, input, mesh)) return what;  // what came before is still its own
  if (auto what = find_skin_fault(after, before, *bound, mesh)) return what;
  input = after;
  return std::nullopt;
}

}  // namespace

const char* operation_name(Operation operation) {
  return kNames[static_cast<std::size_t>(operation)];
}

SequenceResult run_sequence(const SequenceOptions& options) {
  SequenceResult result;
  RandomBody body = make_random_body(options.seed);
  result.body = body.name;
  SplitMix64 random(options.seed ^ 0x5eedULL);
  TetMesh input = body.mesh;
  ChangingMesh mesh(std::move(body.mesh), random, options.sabotage);
  result.has_kept_region = mesh.kept().has_value();
  for (std::uint64_t n = 1; n <= options.operations; ++n) {
    const Operation operation = draw(random, mesh.is_fusing());
    std::optional<std::string> what;
    try {
      what = perform(operation, mesh, random, input, result);
      const bool is_due = options.check_every > 0 && n % options.check_every == 0;
      if (!what && (is_due || n == options.operations)) {
        what = find_fault(mesh.copy(), input, mesh);
        ++result.checks;
      }
    } catch (const std::exception& error) {
      what = std::string("threw: ") + error.what();
    }
    if (what) {
      result.fault = SequenceFault{n, operation, *what};
      break;
    }
  }
  return result;
}

SequenceFault minimise(const SequenceOptions& options) {
  SequenceOptions trial = options;
  trial.check_every = 0;
  std::uint64_t good = 0;
  std::optional<SequenceFault> found = run_sequence(trial).fault;
  require(found.has_value(), "a sequence that fails");
  while (found->operations - good > 1) {
    trial.operations = good + (found->operations - good) / 2;
    if (auto earlier = run_sequence(trial).fault) {
      found = std::move(earlier);
    } else {
      good = trial.operations;
    }
  }
  return *found;
}

std::string describe_fault(const SequenceOptions& options, const SequenceResult& result,
                           const SequenceFault& fault) {
  return "on " + result.body + (result.has_kept_region ? " with a kept region" : "") + ", after \"" +
         operation_name(fault.last) + "\": " + fault.what +
         "\nreplay: PALPATE_OPERATIONS_SEED=" + std::to_string(options.seed) +
         " PALPATE_OPERATIONS=" + std::to_string(fault.operations) +
         " build/release/bin/palpate_tests --gtest_filter=OperationFuzz.Replay";
}

}  // namespace palpate::testing_support

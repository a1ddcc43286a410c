// A sequence of operations on a random body, drawn from a seed, with the judge as the oracle. The first n
// operations of a sequence are the same however many follow, so that one that fails is replayed by its seed
// and a number, and the least number that fails is found by bisection.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "tests/support/operation_fuzz/random_body.h"

namespace palpate::testing_support {

/// What one operation is.
enum class Operation {
  kRemoveEdge,
  kRemoveFace,
  kEdgesOfTet,
  kSplitEdge,
  kUndo,      ///< of the flip or split just before
  kSmooth,    ///< by the smoother
  kMove,      ///< anywhere around, if all tets stay positive
  kCollapse,  ///< of one edge, if the link condition holds and all tets stay positive
  kCollapseShortest,
  kRepair,
  kSkin,    ///< palpate.surface takes some tets away, skin and inside
  kFuse,    ///< of one tet
  kRebuild  ///< from the mesh of flips and collapses to that of fusions, or back
};
inline constexpr std::size_t kOperations = 13;

/// Its name, such as "collapse".
const char* operation_name(Operation operation);

/// Which operation is broken on purpose, to see that the judge notices.
enum class Sabotage {
  kNone,
  kMoveUnchecked,       ///< moves turn tets over
  kMoveOnBoundary,      ///< moves take boundary vertices too; the mesh stays valid
  kMoveKept,            ///< moves take vertices of kept tets too; the mesh stays valid
  kCollapseUnchecked,   ///< collapses turn tets over
  kCollapseOnBoundary,  ///< collapses take boundary vertices away
  kFuseOnBoundary,      ///< fusions take tets with a boundary vertex
  kLoseTet              ///< removing an edge loses a tet
};

/// Which sequence.
struct SequenceOptions {
  std::uint64_t seed = 1;
  std::uint64_t operations = 1000;
  std::uint64_t check_every = 0;  ///< operations between checks; 0: at the end alone
  Sabotage sabotage = Sabotage::kNone;
};

/// What was wrong, and when.
struct SequenceFault {
  std::uint64_t operations = 0;  ///< done when it was seen
  Operation last = Operation::kRebuild;
  std::string what;
};

/// What became of a sequence.
struct SequenceResult {
  std::string body;
  bool has_kept_region = false;
  std::uint64_t checks = 0;
  std::array<std::uint64_t, kOperations> changed{};  ///< times that each operation changed the mesh
  std::optional<SequenceFault> fault;
};

/// Runs a sequence; ends at the first fault. An exception of an operation is a fault too.
SequenceResult run_sequence(const SequenceOptions& options);

/// Of a sequence that fails after options.operations: the least number of operations that bisection finds
/// such that it fails, and does not with one fewer.
SequenceFault minimise(const SequenceOptions& options);

/// One line to replay a fault by.
std::string describe_fault(const SequenceOptions& options, const SequenceResult& result,
                           const SequenceFault& fault);

}  // namespace palpate::testing_support

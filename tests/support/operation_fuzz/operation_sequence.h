// A sequence of operations on a random body, drawn from a seed, with the judge as the oracle. The first n
// operations of a sequence are the same however many follow, so that one that fails is replayed by its seed
// and a number, and the least number that fails is found by bisection.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "tests/support/operation_fuzz/operation.h"

namespace palpate::testing_support {

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

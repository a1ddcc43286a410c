// A mesh under operations in any order: that of flips, moves and collapses, or that of fusions, by turns.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/random.h"
#include "core/simplify/fusion/fusion.h"
#include "core/simplify/sizing/sizing.h"
#include "core/simplify/tet_operations/flips.h"
#include "core/simplify/tet_operations/smoothing.h"
#include "tests/support/operation_fuzz/operation.h"

namespace palpate::testing_support {

class ChangingMesh {
 public:
  /// In one of three meshes a ball around a vertex is to be left alone.
  ChangingMesh(TetMesh mesh, SplitMix64& random, Sabotage sabotage);
  ~ChangingMesh();
  ChangingMesh(const ChangingMesh&) = delete;
  ChangingMesh& operator=(const ChangingMesh&) = delete;

  /// Whether it is the mesh of fusions at the moment.
  bool is_fusing() const { return fusing_.has_value(); }
  const std::optional<simplify::KeptRegion>& kept() const { return kept_; }
  TetMesh copy() const;

  /// Tries an operation, all but kSkin, somewhere at random. Returns whether the mesh has changed.
  bool perform(Operation operation, SplitMix64& random);

  /// simplify_surface by a few percent, or some passes over the skin: collapses, splits, flips, moves, and
  /// moves for a longer step. Returns how far the skin may be from where it was, or nothing if the mesh is as
  /// it was.
  std::optional<double> change_skin(SplitMix64& random);

 private:
  struct Workshop;  ///< the working mesh and what works on it

  void build(TetMesh mesh);
  bool rebuild();
  bool flip(Operation operation, SplitMix64& random);
  bool insert_vertex(Index tet, SplitMix64& random);
  bool smooth(SplitMix64& random);
  bool move(SplitMix64& random);
  bool collapse(SplitMix64& random);
  bool collapse_shortest(SplitMix64& random);
  bool repair(SplitMix64& random);
  bool fuse(SplitMix64& random);
  bool coarsen_skin(TetMesh& mesh, double bound, SplitMix64& random);
  bool pass_over_skin(TetMesh& mesh, double bound, SplitMix64& random);
  bool may_move(Index v) const;
  void lose_tet(Index tet);

  Sabotage sabotage_;
  std::optional<simplify::KeptRegion> kept_;
  simplify::SizingOptions sizing_;
  simplify::SizingField field_;
  double mean_volume_ = 0.0;
  std::uint64_t most_tets_ = 0;
  std::unique_ptr<Workshop> shop_;
  std::optional<simplify::FusionMesh> fusing_;
  std::vector<std::uint8_t> not_fused_;  ///< one a vertex of the mesh of fusions, by its first numbers
  simplify::FusionPlan plan_;
  bool can_undo_ = false;
};

}  // namespace palpate::testing_support

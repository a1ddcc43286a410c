// Does a skin that changes stay within a bound of the input's, both ways? Each change is proven to before it
// is made.
#pragma once

#include <cstdint>
#include <vector>

#include "core/simplify/cover/cover_check.h"
#include "core/simplify/cover/patch_shift.h"
#include "core/simplify/cover/sheet_cover.h"
#include "core/simplify/skin_guard/coverage.h"
#include "core/simplify/skin_guard/input_skin.h"
#include "core/simplify/skin_guard/skin_faces.h"
#include "core/simplify/tet_operations/working_mesh.h"

namespace palpate::simplify {

/// Remembers which faces cover which triangle of the input's skin, and how far either is from the other at
/// most. A change that shifts the skin by no more than the bound leaves to that needs no other proof.
class SkinDistance {
 public:
  /// Takes `faces`, of the mesh, as the input's skin. `limit`: the bound, in the mesh's unit.
  SkinDistance(const WorkingMesh& mesh, const SkinFaces& faces, double limit);

  const InputSkin& input() const { return input_; }
  /// What is proven of both skins as they are.
  const Coverage& coverage() const { return coverage_; }

  /// Changes the bound for what comes. Throws: ContractError if it is below the one before.
  void raise_limit(double limit);

  /// Whether a vertex may be there: necessary, and cheap.
  bool may_hold(const Vec3& place) const { return cover_.is_near(place, input_.tree()); }

  /// Whether both distances stay within the bound; where not, they may, but that is not proven. Remembers the
  /// proof.
  bool permits(const SkinFaces& faces, const PlannedChange& plan);

  /// The change that was permitted last is made. `slots`: the numbers that there were before it.
  void apply(const BoundaryChange& change, std::size_t slots);

 private:
  const BoundaryChange& change() const { return plan_->change(); }
  const std::vector<PlacedFace>& fresh() const { return plan_->fresh(); }

  void collect_concerned();
  void measure_shift();
  void take_shifted();
  double reach_over_gone(std::size_t fresh) const;
  bool take_shifted_input(Index i);
  CoverProof& add_proof(Index input, double reach);
  void collect_around();
  bool may_stay_near();
  bool reaches_beyond_limit() const;
  void lay_tiles();
  Tile tile_of_input(Index i) const;
  void lay_input_tiles();
  void take_small_faces();
  void take_seen_faces();
  bool face_is_near(std::size_t k);
  bool input_stays_near();
  bool stays_near_input();
  void widen_concerned();

  InputSkin input_;
  CoverTest cover_;
  SheetCover sheet_;
  Coverage coverage_;
  double least_room_;  ///< a bound below this is hardly ever left any by a change: see measure_shift

  // The change under examination.
  const SkinFaces* faces_ = nullptr;
  const PlannedChange* plan_ = nullptr;
  std::vector<Index> concerned_;          // of the input's triangles
  std::vector<std::size_t> open_inputs_;  // places among them: what the shift does not settle
  std::vector<std::size_t> open_faces_;   // of the fresh ones: likewise
  std::vector<double> fresh_reach_;       // of the fresh ones, from the input's skin
  std::vector<std::size_t> fresh_stamp_;  // of the fresh ones: the last proof that asked for it
  PatchShift shift_;
  bool is_shift_known_ = false;
  std::vector<Index> around_;
  std::vector<BoxedTriangle> candidates_;  // the fresh faces, and those around
  bool is_seen_ = false;                   // along a direction
  std::vector<Tile> gone_tiles_;
  std::vector<Tile> face_tiles_;   // of the candidates
  std::vector<Tile> input_tiles_;  // of those concerned
  std::vector<Index> used_;
  std::vector<CoverProof> proofs_;
  std::size_t proof_count_ = 0;
  std::uint32_t stamp_ = 0;
  std::vector<std::uint32_t> seen_stamp_;
  std::vector<std::uint32_t> input_stamp_;
  std::vector<std::uint32_t> point_stamp_;  ///< of the input's vertices
};

}  // namespace palpate::simplify

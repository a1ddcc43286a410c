// Regions of a mesh that a scene needs in full, and how far sizes may grow away from them.
#pragma once

#include <cstdint>
#include <vector>

#include "core/mesh/tet_mesh.h"

namespace palpate::simplify {

/// A part of space whose tets are left alone. Lengths in the mesh's own unit.
struct KeepRegion {
  enum class Kind {
    kSphere,       ///< |x - center| <= radius
    kHalfSpace,    ///< normal . x <= offset: the normal points out of what is kept
    kSurfacePatch  ///< within `depth` of the boundary faces that have a vertex with |v - center| <= radius
  };
  Kind kind = Kind::kSphere;
  Vec3 center{};
  double radius = 0.0;
  Vec3 normal{};  ///< of unit length
  double offset = 0.0;
  double depth = 0.0;
};

/// What to keep, and how sizes grade from there.
struct SizingOptions {
  std::vector<KeepRegion> keep;
  double near_size = 0.5;  ///< relative size at a region's border, in (0, 1]
  double reach =
      0.0;  ///< distance at which the relative size is 1; 0: a quarter of the bounding box's diagonal
};

/// The wanted edge length over that of the far field, and the distance to what is kept.
class SizingField {
 public:
  /// An empty field: keeps nothing, relative size 1 everywhere.
  SizingField() = default;
  /// Throws: InputError for a radius, normal, near_size or reach that makes no sense, or a patch that no
  /// boundary vertex lies in.
  SizingField(const SizingOptions& options, const TetMesh& mesh);

  bool is_empty() const { return regions_.empty(); }
  /// Distance from x to the nearest region; 0 inside. Infinite for an empty field.
  double distance(const Vec3& x) const;
  /// Smooth and Lipschitz: near_size at a region, 1 from `reach` on. In (0, 1].
  double relative_size(const Vec3& x) const;

 private:
  std::vector<KeepRegion> regions_;
  std::vector<std::vector<Triangle>> patches_;  ///< of the regions that are surface patches
  std::vector<Vec3> points_;                    ///< of the patches
  double near_size_ = 1.0;
  double reach_ = 1.0;
};

/// One flag a tet: 1 if it meets a region (a superset by less than one tet's diameter is allowed). Such a tet
/// is in the output as it was, to the bit. Empty for an empty field.
std::vector<std::uint8_t> build_kept_tets(const SizingField& field, const TetMesh& mesh);

/// One flag a vertex: 1 if a kept tet has it. Such a vertex is neither moved nor removed.
std::vector<std::uint8_t> build_kept_vertices(const std::vector<std::uint8_t>& kept_tets,
                                              const TetMesh& mesh);

}  // namespace palpate::simplify

// What acts on the skin of a mesh, carried over to the skin of another mesh of the same body.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <span>
#include <vector>

#include "core/judge/surface/triangle_tree.h"
#include "core/mesh/boundary_problem.h"
#include "core/mesh/face_weights.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::experiments {

/// Carries patches of a whole mesh's skin over to meshes that were made from it by simplifying.
///
/// A place on the other skin has the weight of the face of the whole skin that is nearest. A face that the
/// whole skin has, too, corner for corner, has its weight, to the bit; another one gets that of
/// match_moments, from 256 places on it: a region's border that runs through a coarse face stays where it is
/// for linear elements, where the mean alone would reach up to a face farther.
class PatchCarrier {
 public:
  explicit PatchCarrier(const TetMesh& whole);

  const TetMesh& whole() const { return whole_; }

  /// share(face) is the weight of a face of the whole skin, 0 outside the patch; `boundary` the other mesh's
  /// build_boundary. What acts is to be multiplied by `scale`, at least 1, so that no weight is above 1.
  FacePatch carry(const std::function<double(const Triangle&)>& share, const TetMesh& mesh,
                  std::span<const Triangle> boundary, double& scale) const;

 private:
  using Places = std::array<std::array<double, 3>, 3>;

  static Places places_of(const TetMesh& mesh, const Triangle& face);

  /// What the whole skin's densities come to on a face; `hint` is the face of the last place looked at.
  FaceCover cover_of(const TetMesh& mesh, const Triangle& face, const std::vector<double>& density,
                     const judge::Box& patch_box, Index& hint) const;

  const TetMesh& whole_;
  std::vector<Triangle> skin_;
  judge::TriangleTree tree_;
  std::map<Places, std::size_t> number_;
};

}  // namespace palpate::experiments

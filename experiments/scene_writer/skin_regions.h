// Where an organ can rest and where it can be pressed, found on its skin.
#pragma once

#include <cstddef>
#include <optional>

#include "core/mesh/tet_mesh.h"

namespace palpate::experiments {

/// The part of the skin that lies lowest: all x with up . x up to a share of the body's extent along `up`.
struct RestingRegion {
  double share = 0.0;       ///< of the extent
  double area_share = 0.0;  ///< of the skin, as a scene's weights have it
  std::size_t faces = 0;    ///< of the skin, wholly or partly in it
  bool stands = false;      ///< the centre of mass is over the middle half of it, whichever way one looks
};

/// A round pad on the skin, on top.
struct PadRegion {
  std::optional<Vec3> direction;  ///< from the centroid; nothing: the ray along `up` meets no skin
  Vec3 center_m;
  double radius_m = 0.0;     ///< a number of three digits
  Vec3 normal;               ///< mean outward normal of the skin below it, of length 1
  double thickness_m = 0.0;  ///< extent of the body along the normal, within the radius of its line
  double mean_edge_m = 0.0;  ///< of the skin
  double area_share = 0.0;
  std::size_t faces = 0;
  bool reaches_round =
      false;  ///< takes hold of the other side too: the part is thinner than the skin's edges
};

/// The least share, in hundredths, that takes in a fifth of the skin's area by the centroids of its faces and
/// lets the body stand; up to 60 hundredths.
/// Requires: points in metres, `up` of length 1.
RestingRegion find_resting_region(const TetMesh& mesh, const Vec3& up);

/// The pad is where the ray from the centroid along `up` leaves the body, or on the highest face where there
/// is no such place. It covers about 4% of the skin and is at least three edges of it wide; it is made
/// smaller, down to two edges, as long as it reaches round to skin that looks the other way. Requires: as
/// above.
PadRegion find_pad_region(const TetMesh& mesh, const Vec3& up);

}  // namespace palpate::experiments

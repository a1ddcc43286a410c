// A region of a scene: a part of space that a clamp or a load takes hold of, given in metres or by the mesh.
#pragma once

#include <optional>
#include <string>

#include "core/base/types.h"
#include "core/mesh/tet_mesh.h"
#include "experiments/text/yaml_value.h"

namespace palpate::experiments {

/// A part of space as a scene gives it. What is given by the mesh is turned into metres by place_region().
///
///   {sphere: {center_m: [x, y, z], radius_m: r}}          all within r of the centre
///   {half_space: {normal: [x, y, z], offset_m: d}}        all x with n . x <= d, n of length 1
///   {box: {low_m: [x, y, z], high_m: [x, y, z]}}          all between two corners
///
/// By the mesh: a sphere's centre as `surface_point: {direction: d}`, where the ray from the mesh's centroid
/// in the direction d leaves the mesh for the last time; its radius as `radius_relative`, a share of the
/// longest side of the mesh's box; a half-space's offset as `share`, how much of the mesh's extent along the
/// normal it takes in.
struct Region {
  enum class Kind { kSphere, kHalfSpace, kBox };

  Kind kind = Kind::kSphere;
  Vec3 center;  ///< kSphere, in m
  double radius = 0.0;
  Vec3 normal;  ///< kHalfSpace: of length 1
  double offset = 0.0;
  Vec3 low;  ///< kBox, in m
  Vec3 high;
  std::optional<Vec3> surface_direction;  ///< kSphere: the centre, until it is placed
  std::optional<double> radius_relative;
  std::optional<double> share;  ///< kHalfSpace: the offset, until it is placed
  std::string where;            ///< "kidney.yaml:12", for messages
  std::string text;             ///< "half_space", for messages
};

/// Reads the region out of the keys of a clamp or a load: one of sphere, half_space, box.
/// Throws: InputError with file and line.
Region read_region(const YamlFields& fields);

/// A list of three finite numbers. Throws: InputError with file and line.
Vec3 read_vector(const YamlValue& value);

/// The region in metres alone. Throws: InputError if a ray from the centroid misses the mesh's boundary.
Region place_region(Region region, const TetMesh& mesh);

/// Whether a point lies in a placed region, or within `tolerance` of it.
bool is_inside(const Region& region, const Vec3& point, double tolerance);

/// Why a placed region cannot have been meant for this mesh: its border is farther than 10 times the longest
/// side of the mesh's box away from that box, as with a wrong unit of length. Empty if it can.
std::string unit_complaint(const Region& region, const TetMesh& mesh);

}  // namespace palpate::experiments

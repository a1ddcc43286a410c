// The keys of a mesh that is made, as plans, scenes and trainings share them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "experiments/meshes/mesh_source.h"
#include "experiments/text/yaml_value.h"

namespace palpate::experiments {

/// The most vertices that a mesh may be made of, and the largest seed of anything drawn at random.
inline constexpr std::int64_t kMostVertices = std::int64_t{1} << 29;
inline constexpr std::int64_t kLargestSeed = std::int64_t{1} << 40;

/// vertices, edge_length, skin, seed, jitter: what may stand beside `make`.
const std::vector<std::string>& shape_keys();

/// `more`, with shape_keys() behind them.
std::vector<std::string> with_shape_keys(std::vector<std::string> more);

/// Reads the shape that `make` names. Throws: InputError with file and line for an unknown shape, a value out
/// of range, or a key that the shape does not take.
ShapeRequest read_shape_fields(const YamlFields& fields, const YamlValue& make);

/// Throws: InputError with file and line if a mesh from a file has one of shape_keys().
void refuse_shape_keys(const YamlFields& fields);

/// Reads what may stand beside the file of a surface: vertices or edge_length. Throws: InputError with file
/// and line for both, for a value out of range, and for a key of a shape that no surface takes.
MeshSize read_surface_size(const YamlFields& fields);

}  // namespace palpate::experiments

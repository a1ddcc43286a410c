// A scene on a mesh: regions become faces, totals become tractions, and what cannot be solved is refused.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/mesh/boundary_problem.h"
#include "core/mesh/tet_mesh.h"
#include "experiments/scene_reader/scene.h"

namespace palpate::experiments {

/// What is odd about the length of a scene's body in metres, in one line; an empty string for one of 1 mm to
/// 5 m.
std::string size_complaint(const SceneMesh& how, const TetMesh& mesh);

/// The scene's mesh in metres. `vertices` replaces the count of a made shape or a filled surface. One that is
/// longer or shorter than any organ gets a note. Throws: InputError or UnavailableError as make_shape,
/// mesh_surface and read_mesh do; InputError for `vertices` of a file with tets, or a file whose mesh is
/// invalid.
MadeMesh build_scene_mesh(const SceneMesh& mesh, std::optional<std::uint64_t> vertices = std::nullopt);

/// The scene with all regions in metres, placed by its own mesh: on another mesh of the same body, a
/// simplified one say, it still means the same parts of space.
/// Throws: InputError for a region far from the mesh, and a tool that is moved farther than the mesh is long.
Scene place_scene(Scene scene, const TetMesh& mesh);

/// A placed scene for meshes that are made from `whole` by simplifying: what takes hold of its skin is
/// carried over to theirs. One that has a whole mesh already keeps it.
Scene on_whole(Scene placed, const TetMesh& whole);

/// A placed scene on a mesh in metres, by its boundary faces.
///
/// The weight of a face in a region is the share of 256 equal parts of it whose centroids lie in the region.
/// On a simplified mesh (a scene with `whole`) it is what the whole mesh's skin has there, carried over by
/// PatchCarrier; a support's stiffness is then higher by what that scales weights by. A hard clamp or
/// displacement holds the boundary faces all of whose vertices lie in the region. A total force becomes a
/// uniform traction over the weighted area, so that the total is kept whatever the mesh.
///
/// Requires: points in metres, positive tets.
/// Throws: InputError that starts with the region's place for one that takes hold of no face (or lies so far
///         off that its unit must be wrong), for vertices that are held in two ways, and for a body with a
///         rigid motion left free, naming that motion.
BoundaryProblem build_problem(const Scene& placed, const TetMesh& mesh);

/// The same for a body that may move as a whole: no rigid motion needs to be held.
BoundaryProblem resolve_problem(const Scene& placed, const TetMesh& mesh);

}  // namespace palpate::experiments

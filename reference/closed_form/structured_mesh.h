// Meshes of mapped blocks and shells, for cases whose geometry is known in closed form.
#pragma once

#include <functional>
#include <vector>

#include "core/base/types.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::reference {

/// Cells of a block along its three sides.
struct BlockCells {
  int x = 1;
  int y = 1;
  int z = 1;
};

/// The block [0, 1]^3 of cells of six Kuhn tets each, all split along the diagonal from (0, 0, 0) to (1, 1,
/// 1), with every vertex moved to map(vertex). Vertices in the order of x, then y, then z. Throws: InputError
/// unless each side has 1 to 400 cells; ContractError if `map` turns a tet over.
TetMesh build_mapped_block(const BlockCells& cells, const std::function<Vec3(const Vec3&)>& map);

/// The eighth of a spherical shell where x, y and z are not negative: the triangle between the axes divided
/// into cells^2 triangles and pushed out to the sphere, in `layers` layers of equal thickness from `inner` to
/// `outer`. Vertices on the planes between the axes lie on them to the bit. Throws: InputError unless cells
/// and layers are 1 to 400 and 0 < inner < outer.
TetMesh build_shell_octant(int cells, int layers, double inner, double outer);

/// The boundary faces of `mesh` whose three vertices all fulfil `holds`, as build_boundary orders them.
std::vector<Triangle> select_boundary(const TetMesh& mesh, const std::function<bool(const Vec3&)>& holds);

}  // namespace palpate::reference

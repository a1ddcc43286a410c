// The boundary of a tet mesh as a surface of its own.
#pragma once

#include "core/mesh/tet_mesh.h"

namespace palpate::reference {

/// The boundary triangles, counter-clockwise seen from outside, and the vertices that they use, in the mesh's
/// order. Throws: InputError if a face has more than two tets, or two on the same side.
SurfaceMesh take_skin(const TetMesh& mesh);

}  // namespace palpate::reference

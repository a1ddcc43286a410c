// Meshes of bodies, real organs first: from a finely sampled skin to a filled surface.
#pragma once

#include "experiments/meshes/shape_request.h"

namespace palpate::experiments {

/// Is it the name of a body (list_bodies())?
bool is_body(const std::string& name);

/// Makes a body by name, in mm, axes as in its source; for an organ of the CT the voxels' centroid is the
/// origin.
///
/// Fine surface (VTK from the CT, a scan, a formula) -> skin of the wanted edges (CGAL) -> scaled about its
/// vertices' mean to the body's volume -> tets (gmsh), the interior finer than a coarse skin, as fine as a
/// fine one. Throws: as make_shape().
MadeMesh make_body(const ShapeRequest& request);

}  // namespace palpate::experiments

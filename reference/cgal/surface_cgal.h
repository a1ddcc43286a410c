// Surfaces as CGAL has them, for the sources that work on them. Included by programs that are built with
// CGAL, GPL.
#pragma once

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>

#include "core/mesh/tet_mesh.h"

namespace palpate::reference {

using SurfaceKernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using CgalSurface = CGAL::Surface_mesh<SurfaceKernel::Point_3>;

/// The surface as CGAL has it, vertices and triangles in the same order. Requires: a manifold surface whose
/// triangles all turn the same way.
CgalSurface to_cgal(const SurfaceMesh& surface);

/// Requires: no garbage; triangles alone.
SurfaceMesh from_cgal(const CgalSurface& mesh);

/// A vertex's place.
Vec3 point_of(const CgalSurface& mesh, CgalSurface::Vertex_index vertex);

/// Twice the area vector of a triangle, outward if it is counter-clockwise seen from outside.
Vec3 normal_of(const CgalSurface& mesh, CgalSurface::Face_index face);

}  // namespace palpate::reference

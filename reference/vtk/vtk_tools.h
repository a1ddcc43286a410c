// Tools on VTK: an organ's surface from a labelled image, any surface as marching cubes leave it, and .vtk /
// .vtu files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/mesh/tet_mesh.h"

class vtkPolyData;

namespace palpate::reference {

/// How a label becomes a surface; lengths in the image's unit.
struct OrganOptions {
  int label = 0;
  double smoothing = 1.0;  ///< standard deviation of the Gaussian that smooths the mask
  double spacing = 1.0;    ///< of the grid that the smoothed mask is sampled on
};

/// A smooth closed surface and what the voxels say.
struct OrganSurface {
  SurfaceMesh surface;        ///< moved so that the voxels' centroid is the origin
  double voxel_volume = 0.0;  ///< of the label's largest component, cavities filled
  Vec3 centroid;              ///< of the voxels, in the image's coordinates
};

/// Largest component of a label -> Gaussian-smoothed mask -> coarser grid -> the surface at one half ->
/// windowed-sinc smoothing. Throws: InputError if the image cannot be read, has no such label, or the surface
/// does not come out as one
///         closed piece.
OrganSurface extract_organ(const std::filesystem::path& image, const OrganOptions& options);

/// The surface as an image of it has it: the signed distance on a grid of voxels, in grey levels (128 to a
/// voxel), and marching cubes (flying edges) between two of them. It crosses the
/// grid's edges wherever that happens to be, also next to their ends, so it has needles. The seed says where
/// the grid lies. `spacing`: of the voxels. Throws: InputError for a spacing that is not positive or takes
/// more than 5e7 voxels.
SurfaceMesh march_surface(const SurfaceMesh& surface, double spacing, std::uint64_t seed);

/// The triangles of a closed surface in VTK's form, without points that none of them uses, moved so that
/// `origin` is the origin, turned outwards.
SurfaceMesh closed_surface_of(vtkPolyData* data, const Vec3& origin);

/// Reads a .vtk (legacy) or .vtu unstructured grid of linear tets. Vertices, lines and triangles are left out
/// and noted. Throws: InputError naming any other cell kind, or a file that VTK cannot read.
TetMesh read_grid(const std::filesystem::path& path, std::vector<std::string>& notes);

/// Writes a .vtu file of binary appended data; the same mesh gives the same bytes.
void write_vtu(const std::filesystem::path& path, const TetMesh& mesh);

}  // namespace palpate::reference

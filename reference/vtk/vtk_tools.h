// Tools on VTK: an organ's surface from a labelled image, and .vtk / .vtu files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/mesh/tet_mesh.h"

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

/// Reads a .vtk (legacy) or .vtu unstructured grid of linear tets. Vertices, lines and triangles are left out
/// and noted. Throws: InputError naming any other cell kind, or a file that VTK cannot read.
TetMesh read_grid(const std::filesystem::path& path, std::vector<std::string>& notes);

/// Writes a .vtu file of binary appended data; the same mesh gives the same bytes.
void write_vtu(const std::filesystem::path& path, const TetMesh& mesh);

}  // namespace palpate::reference

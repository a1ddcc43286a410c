// The real organs: from a segmented CT to a filled surface.
#pragma once

#include "experiments/mesh_source.h"

namespace palpate::experiments {

/// Is it the name of a real organ?
bool is_organ(const std::string& name);

/// The folder `organ_data` below the build folder, or below PALPATE_CACHE.
std::filesystem::path organ_data_folder();

/// Hash of the image that the organs are made from, which is fetched if it is not there yet. Throws:
/// UnavailableError if it cannot be had.
std::string organ_image_hash();

/// Makes "kidney" or "liver", in mm, the voxels' centroid at the origin, axes as in the image.
///
/// Label -> smooth surface (VTK) -> coarse skin (CGAL) -> scaled about its centroid to the voxels' volume ->
/// tets (gmsh), the interior finer than the skin. Throws: as make_shape().
MadeMesh make_organ(const std::string& name, const MeshSize& size);

}  // namespace palpate::experiments

// The finely sampled skins that meshes of bodies are made from: a segmented CT, scanned surfaces, built ones.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/mesh/tet_mesh.h"

namespace palpate::experiments {

/// A body that can be made, all in mm.
struct BodyInfo {
  std::string name;
  std::string summary;
  bool needs_image = false;  ///< cut out of the CT by VTK
};

/// The folder `organ_data` below the build folder, or below PALPATE_CACHE.
std::filesystem::path organ_data_folder();

/// All bodies, in the order in which they are listed.
const std::vector<BodyInfo>& list_bodies();

/// The body's fine skin, the volume that its meshes are scaled to, and where both come from.
struct BodySurface {
  SurfaceMesh surface;
  double volume = 0.0;    ///< mm^3
  std::string source;     ///< "label 127 of a segmented CT in mm, voxels 159.5 ml", for notes
  std::string volume_of;  ///< "the voxels' volume", for notes
  std::string origin;     ///< where the origin is, for notes; empty if there is nothing to say
};

/// Its name is one of list_bodies(). Throws: ContractError for another; UnavailableError if a program, a
/// package or the data is missing, or if what it gives is not the closed surface that it should be.
BodySurface load_body_surface(const std::string& name);

/// "; data " and the hash of the file that the body is made from, for the key under which its meshes are
/// kept; empty for a built one. Fetches the file if it is not there yet. Throws: as load_body_surface().
std::string body_data_key(const std::string& name);

}  // namespace palpate::experiments

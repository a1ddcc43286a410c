#include "experiments/organ_source.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/off.h"
#include "experiments/file_hash.h"
#include "experiments/mesh_cache.h"
#include "experiments/mesh_fill.h"
#include "experiments/mesh_tools.h"
#include "experiments/places.h"
#include "experiments/process.h"

namespace palpate::experiments {
namespace {

constexpr std::uint64_t kDefaultVertices = 1503;  // the thesis's mesh
constexpr std::uint64_t kFewestVertices = 100;
constexpr std::uint64_t kMostVertices = 2'000'000;
constexpr double kSkinToInterior = 2.2;     // gives the thesis's ratio of edges to vertices
constexpr double kFirstInteriorSize = 4.0;  // mm, for kidney of 159 ml and 1503 vertices
constexpr double kFirstVolume = 159.5e3;    // mm^3

/// An organ of the image, and how finely its surface is sampled.
struct Organ {
  const char* name;
  int label;
  double smoothing_mm;
  double spacing_mm;
};
// 5 mm close the kidney's sinus, which an organ's capsule bridges too. With 1.5 mm the mesh is so thin there
// that only 68 fusions are possible, fewer than the thesis's 87; with 5 mm 103 are. The coarse skin is
// then 2.5% short of the voxels.
constexpr std::array<Organ, 2> kOrgans{{{"kidney", 127, 5.0, 1.25}, {"liver", 255, 3.0, 2.5}}};

const Organ* find_organ(const std::string& name) {
  for (const Organ& organ : kOrgans) {
    if (name == organ.name) return &organ;
  }
  return nullptr;
}

std::string first_line(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

/// The unpacked image, fetched on first use.
std::filesystem::path organ_image() {
  const std::filesystem::path folder = organ_data_folder();
  std::filesystem::path image = folder / "liver.inr";
  if (std::filesystem::exists(image)) return image;
  const ScratchFolder scratch;
  ProcessSpec spec;
  spec.arguments = {"/bin/bash", source_folder() + "/reference/organ_data.sh", folder.string()};
  spec.timeout_s = 600.0;
  spec.standard_error = scratch.file("errors");
  const ProcessResult result = run_process(spec);
  if (result.exit_code != 0 || !std::filesystem::exists(image)) {
    const std::string line = first_line(scratch.file("errors"));
    throw UnavailableError("the organs' image could not be had from the Debian package libcgal-demo: " +
                           (line.empty() ? result.message : line));
  }
  return image;
}

/// The organ's smooth surface and the volume of its voxels.
struct SmoothOrgan {
  SurfaceMesh surface;
  double voxel_volume = 0.0;
};

SmoothOrgan extract_surface(const Organ& organ) {
  const ScratchFolder scratch;
  ToolCall call{"mesh", "vtk.organ_surface", organ_image(), scratch.file("organ.off"), {}, 300.0};
  call.options = {{"label", organ.label}, {"smoothing", organ.smoothing_mm}, {"spacing", organ.spacing_mm}};
  const nlohmann::json response = run_tool(kVtkTool, call);
  SmoothOrgan smooth{read_off(call.output), response.at("report").at("voxel_volume").get<double>()};
  const SurfaceMesh& s = smooth.surface;
  if (s.points.size() != s.triangles.size() / 2 + 2) {
    throw UnavailableError(std::string("the surface of the ") + organ.name + " is not a sphere");
  }
  return smooth;
}

/// Coarse skin, scaled about its vertices' mean to the voxels' volume.
SurfaceMesh make_skin(const SmoothOrgan& organ, double edge_length) {
  SurfaceMesh skin = remesh_surface(organ.surface, edge_length);
  if (skin.points.size() != skin.triangles.size() / 2 + 2) {
    throw UnavailableError("remeshing changed the topology of the organ's surface");
  }
  Vec3 centre;
  for (const Vec3& p : skin.points) centre = centre + p;
  centre = (1.0 / static_cast<double>(skin.points.size())) * centre;
  const double factor = std::cbrt(organ.voxel_volume / enclosed_volume(skin));
  for (Vec3& p : skin.points) p = centre + factor * (p - centre);
  return skin;
}

std::string describe(const Organ& organ, const SmoothOrgan& smooth, const FilledSurface& filled) {
  std::array<char, 256> text{};
  std::snprintf(
      text.data(), text.size(),
      "%s: label %d of a segmented CT in mm, voxels %.1f ml, mesh %.1f ml; skin of %zu vertices scaled to "
      "the voxels' volume; interior edges about %.3g mm; the voxels' centroid is the origin",
      organ.name, organ.label, smooth.voxel_volume / 1000.0, total_volume(filled.mesh) / 1000.0,
      filled.skin.points.size(), filled.interior_size);
  return text.data();
}

}  // namespace

bool is_organ(const std::string& name) {
  return find_organ(name) != nullptr;
}

std::filesystem::path organ_data_folder() {
  return cache_root() / "organ_data";
}

std::string organ_image_hash() {
  return hash_file(organ_image());
}

MadeMesh make_organ(const std::string& name, const MeshSize& size) {
  const Organ* organ = find_organ(name);
  require(organ != nullptr, "make_organ: not an organ");
  const std::uint64_t vertices = size.vertices.value_or(kDefaultVertices);
  if (vertices < kFewestVertices || vertices > kMostVertices) {
    throw InputError(name, 0, "100 to 2000000 vertices", std::to_string(vertices));
  }
  if (size.edge_length) check_interior_size(kFirstVolume, *size.edge_length);
  const SmoothOrgan smooth = extract_surface(*organ);
  const auto skin = [&](double interior) { return make_skin(smooth, kSkinToInterior * interior); };
  FilledSurface filled;
  if (size.edge_length) {
    check_interior_size(smooth.voxel_volume, *size.edge_length);
    filled = fill_surface(skin(*size.edge_length), *size.edge_length);
  } else {
    const double start =
        kFirstInteriorSize * std::cbrt(smooth.voxel_volume / kFirstVolume *
                                       static_cast<double>(kDefaultVertices) / static_cast<double>(vertices));
    filled = fill_with_skin(skin, vertices, start, name);
  }
  MadeMesh made;
  made.notes.push_back(describe(*organ, smooth, filled));
  made.mesh = std::move(filled.mesh);
  return made;
}

}  // namespace palpate::experiments

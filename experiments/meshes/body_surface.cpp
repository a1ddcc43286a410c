#include "experiments/meshes/body_surface.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <variant>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/io/off.h"
#include "core/mesh/shapes/body_surfaces.h"
#include "experiments/files/file_cache.h"
#include "experiments/files/file_hash.h"
#include "experiments/files/places.h"
#include "experiments/meshes/mesh_tools.h"
#include "experiments/processes/process.h"

namespace palpate::experiments {

std::filesystem::path organ_data_folder() {
  return cache_root() / "organ_data";
}

namespace {

/// An organ of the CT, and how finely its surface is sampled.
struct ImageBody {
  int label;
  double smoothing_mm;
  double spacing_mm;
};

/// A closed surface among CGAL's data, scaled so that the longest side of its box is `length_mm`.
struct ScannedBody {
  const char* member;
  double length_mm;
};

struct BuiltBody {
  SurfaceMesh (*build)(int frequency);
};

/// Where a body comes from. `euler`: of its skin, 2 for each sphere and less 2 for each handle.
struct Body {
  const char* name;
  const char* summary;
  std::variant<ImageBody, ScannedBody, BuiltBody> source;
  std::int64_t euler;
};

constexpr const char* kImage = "data/images/liver.inr.gz";
constexpr int kBuiltFrequency = 32;  // 10,242 vertices, far finer than a coarse skin

// 5 mm close the kidney's sinus, which an organ's capsule bridges too. With 1.5 mm the mesh is so thin there
// that only 68 fusions are possible, fewer than the thesis's 87; with 5 mm 103 are. The coarse skin is
// then 2.5% short of the voxels. What follows the liver came later: nothing in the project was chosen on it.
constexpr std::array<Body, 9> kBodies{{
    {"kidney", "a real human kidney of 159 ml, from a segmented CT", ImageBody{127, 5.0, 1.25}, 2},
    {"liver", "a real human liver of 1.6 l, from a segmented CT", ImageBody{255, 3.0, 2.5}, 2},
    {"gallbladder", "9 ml that lie against the liver in the same CT: its gall bladder, by place and size",
     ImageBody{85, 1.5, 0.6}, 2},
    {"bear", "a scanned toy bear with four limbs, scaled to 150 mm",
     ScannedBody{"data/meshes/bear_bis.off", 150.0}, 2},
    {"fist", "a scanned fist with deep creases, scaled to 100 mm", ScannedBody{"data/meshes/hand.off", 100.0},
     2},
    {"spleen", "built: a thin curved leaf with two notches, 112 mm long and 16 mm thick",
     BuiltBody{build_spleen_surface}, 2},
    {"stomach", "built: a bent closed bag of 180 mm with a cavity, walls of 15 to 29 mm",
     BuiltBody{build_stomach_surface}, 4},
    {"lobes", "built: six unlike lobes around a core, 100 mm across", BuiltBody{build_lobes_surface}, 2},
    {"ring", "built: a ring of genus 1 and of uneven thickness, 110 mm across", BuiltBody{build_ring_surface},
     0},
}};

std::string first_line(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

/// A file of CGAL's data, unpacked; fetched on first use.
std::filesystem::path cgal_data(const std::string& member) {
  const std::filesystem::path folder = organ_data_folder();
  std::filesystem::path name = std::filesystem::path(member).filename();
  if (name.extension() == ".gz") name = name.stem();
  std::filesystem::path file = folder / name;
  if (std::filesystem::exists(file)) return file;
  const ScratchFolder scratch;
  ProcessSpec spec;
  spec.arguments = {"/bin/bash", source_folder() + "/reference/organ_data.sh", folder.string(), member};
  spec.timeout_s = 600.0;
  spec.standard_error = scratch.file("errors");
  const ProcessResult result = run_process(spec);
  if (result.exit_code != 0 || !std::filesystem::exists(file)) {
    const std::string line = first_line(scratch.file("errors"));
    throw UnavailableError(
        "the body's data (" + member +
        ") could not be had from the Debian package libcgal-demo: " + (line.empty() ? result.message : line));
  }
  return file;
}

BodySurface from_image(const ImageBody& body) {
  const ScratchFolder scratch;
  ToolCall call{"mesh", "vtk.organ_surface", cgal_data(kImage), scratch.file("organ.off"), {}, 300.0};
  call.options = {{"label", body.label}, {"smoothing", body.smoothing_mm}, {"spacing", body.spacing_mm}};
  const nlohmann::json response = run_tool(kVtkTool, call);
  BodySurface result;
  result.surface = read_off(call.output);
  result.volume = response.at("report").at("voxel_volume").get<double>();
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), "label %d of a segmented CT in mm, voxels %.1f ml", body.label,
                result.volume / 1000.0);
  result.source = text.data();
  result.volume_of = "the voxels' volume";
  result.origin = "; the voxels' centroid is the origin";
  return result;
}

BodySurface from_scan(const ScannedBody& body) {
  const ScratchFolder scratch;
  run_tool(kSurfaceTool,
           {"convert", "cgal.read_surface", cgal_data(body.member), scratch.file("surface.off"), {}, 300.0});
  BodySurface result;
  result.surface = read_off(scratch.file("surface.off"));
  const BoundingBox box = bounding_box(result.surface.points);
  const double scale = body.length_mm / longest_side(box);
  const Vec3 middle = 0.5 * (box.low + box.high);
  for (Vec3& p : result.surface.points) p = scale * (p - middle);
  result.volume = enclosed_volume(result.surface);
  std::array<char, 128> text{};
  std::snprintf(text.data(), text.size(), "%s of CGAL's data, scaled to %g mm, %.1f ml",
                std::filesystem::path(body.member).filename().c_str(), body.length_mm,
                result.volume / 1000.0);
  result.source = text.data();
  result.volume_of = "the scan's volume";
  result.origin = "; the middle of the scan's box is the origin";
  return result;
}

BodySurface from_formula(const BuiltBody& body) {
  BodySurface result;
  result.surface = body.build(kBuiltFrequency);
  result.volume = enclosed_volume(result.surface);
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "built, in mm, %.1f ml", result.volume / 1000.0);
  result.source = text.data();
  result.volume_of = "the built volume";
  return result;
}

const Body* find_body(const std::string& name) {
  const auto* body =
      std::find_if(kBodies.begin(), kBodies.end(), [&](const Body& b) { return name == b.name; });
  require(body != kBodies.end(), "not the name of a body");
  return body;
}

}  // namespace

const std::vector<BodyInfo>& list_bodies() {
  static const std::vector<BodyInfo> bodies = [] {
    std::vector<BodyInfo> list;
    list.reserve(kBodies.size());
    for (const Body& body : kBodies)
      list.push_back({body.name, body.summary, std::holds_alternative<ImageBody>(body.source)});
    return list;
  }();
  return bodies;
}

std::string body_data_key(const std::string& name) {
  const Body* body = find_body(name);
  const char* member = nullptr;
  if (std::holds_alternative<ImageBody>(body->source)) member = kImage;
  if (const auto* scan = std::get_if<ScannedBody>(&body->source)) member = scan->member;
  return member == nullptr ? "" : "; data " + hash_file(cgal_data(member));
}

BodySurface load_body_surface(const std::string& name) {
  const Body* body = find_body(name);
  BodySurface result;
  if (const auto* image = std::get_if<ImageBody>(&body->source)) result = from_image(*image);
  if (const auto* scan = std::get_if<ScannedBody>(&body->source)) result = from_scan(*scan);
  if (const auto* built = std::get_if<BuiltBody>(&body->source)) result = from_formula(*built);
  const auto euler = static_cast<std::int64_t>(result.surface.points.size()) -
                     static_cast<std::int64_t>(result.surface.triangles.size() / 2);
  if (euler != body->euler)
    throw UnavailableError("the surface of the " + name + " has V - E + F = " + std::to_string(euler) +
                           " in the place of " + std::to_string(body->euler));
  return result;
}

}  // namespace palpate::experiments

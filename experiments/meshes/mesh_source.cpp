#include "experiments/meshes/mesh_source.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <functional>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/base/plain_file.h"
#include "core/mesh/geometry.h"
#include "core/mesh/io/off.h"
#include "core/mesh/orientation.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "experiments/files/file_hash.h"
#include "experiments/files/plain_file.h"
#include "experiments/judging/doubled_points.h"
#include "experiments/meshes/body_surface.h"
#include "experiments/meshes/mesh_cache.h"
#include "experiments/meshes/mesh_fill.h"
#include "experiments/meshes/mesh_tools.h"
#include "experiments/meshes/organ_source.h"
#include "experiments/meshes/skin_jitter.h"
#include "experiments/text/nearest_name.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace {

constexpr std::uint64_t kMostVertices = 5'000'000;
constexpr double kDefaultJitter = 0.25;  // cells

/// A built surface that is filled: ball, bean, filled_bar.
struct FilledShape {
  const char* name;
  SurfaceMesh (*build)(int frequency);
};
constexpr std::array<FilledShape, 3> kFilledShapes{
    {{"ball", build_geodesic_sphere}, {"bean", build_bean_surface}, {"filled_bar", build_bar_surface}}};

/// A lattice: its vertex count is a known function of the cells.
struct LatticeShape {
  const char* name;
  TetMesh (*build)(int cells, const ShapeRequest& request);
  double (*vertices)(double cells);
  int most_cells;
};

constexpr std::array<LatticeShape, 3> kLatticeShapes{{
    {"cube",
     [](int n, const ShapeRequest& r) {
       return build_kuhn_cube(n, r.jitter.value_or(kDefaultJitter), r.seed);
     },
     [](double n) { return (n + 1) * (n + 1) * (n + 1); }, 560},
    {"bar", [](int n, const ShapeRequest&) { return build_bar(n); },
     [](double n) { return (4 * n + 1) * (n + 1) * (n + 1); }, 350},
    {"bcc_bar", [](int n, const ShapeRequest&) { return build_bcc_bar(n); },
     [](double n) { return (4 * n + 1) * (n + 1) * (n + 1) + 4 * n * n * n + 18 * n * n; }, 270},
}};

void check_vertex_count(const std::string& where, std::uint64_t vertices) {
  if (vertices >= kFewestVertices && vertices <= kMostVertices) return;
  throw InputError(where, 0, "100 to 5000000 vertices", std::to_string(vertices));
}

std::string describe(const char* name, const FilledSurface& filled) {
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), "%s: skin of %zu vertices, interior edges about %.3g", name,
                filled.skin.points.size(), filled.interior_size);
  return text.data();
}

/// The skin's frequency goes with the interior's size. Coarse: 6 (362 vertices) at the default count. Fine:
/// as long as the edges inside.
MadeMesh make_filled(const FilledShape& shape, const ShapeRequest& request) {
  constexpr double kFrequency = 6.0;
  constexpr double kInnerVertices = 1141.0;  // 1503 - 362
  constexpr double kMostFrequency = 350.0;   // of filled_bar, and more than enough for the others
  constexpr double kScannedOver = 2.0;       // what is scanned has edges half as long
  const MeshSize& size = request.size;
  const auto build = [&](double f) {
    return shape.build(static_cast<int>(std::clamp(std::round(f), 2.0, kMostFrequency)));
  };
  const auto skin = [&](double frequency) {
    SurfaceMesh built = build(frequency);
    jitter_skin(request.seed, built);
    return built;
  };
  FilledSurface filled;
  if (request.skin != SkinKind::kCoarse) {
    const SurfaceMesh first = skin(kFrequency);
    const double edge_at_1 = kFrequency * mean_edge(first);  // edges go with 1 / frequency
    const auto fine_skin = [&](double interior) {
      if (request.skin == SkinKind::kFine) return skin(edge_at_1 / interior);
      return march_surface(build(kScannedOver * edge_at_1 / interior), interior, request.seed);
    };
    const std::uint64_t vertices = size.vertices.value_or(kDefaultVertices);
    if (size.edge_length) {
      check_interior_size(enclosed_volume(first), *size.edge_length);
      filled = fill_surface(fine_skin(*size.edge_length), *size.edge_length);
    } else {
      check_vertex_count(shape.name, vertices);
      const double start = estimate_interior_size(enclosed_volume(first), static_cast<double>(vertices));
      filled = fill_with_skin(fine_skin, vertices, start, shape.name);
    }
  } else if (size.edge_length) {
    const double volume = enclosed_volume(skin(kFrequency));
    check_interior_size(volume, *size.edge_length);
    const double default_size = estimate_interior_size(volume, kInnerVertices);
    filled = fill_surface(skin(kFrequency * default_size / *size.edge_length), *size.edge_length);
  } else {
    const std::uint64_t vertices = size.vertices.value_or(kDefaultVertices);
    check_vertex_count(shape.name, vertices);
    const double wanted = static_cast<double>(vertices);
    const SurfaceMesh surface = skin(kFrequency * std::cbrt(wanted / static_cast<double>(kDefaultVertices)));
    const double inner = wanted - static_cast<double>(surface.points.size());
    filled = fill_to_vertices(surface, vertices, estimate_interior_size(enclosed_volume(surface), inner));
    require_vertices(filled, vertices, shape.name);
  }
  MadeMesh made;
  made.notes.push_back(describe(shape.name, filled));
  made.mesh = std::move(filled.mesh);
  return made;
}

MadeMesh make_lattice(const LatticeShape& shape, const ShapeRequest& request) {
  int cells = 1;
  if (request.size.edge_length) {
    const double wanted = std::round(1.0 / *request.size.edge_length);
    if (!(*request.size.edge_length > 0.0) || wanted > shape.most_cells) {
      throw InputError(shape.name, 0, "an edge length of at least 1/" + std::to_string(shape.most_cells),
                       short_number(*request.size.edge_length));
    }
    cells = std::max(1, static_cast<int>(wanted));
  } else {
    const auto wanted = static_cast<double>(request.size.vertices.value_or(kDefaultVertices));
    if (wanted < 1.0 || wanted > 1.1 * shape.vertices(shape.most_cells)) {
      throw InputError(
          shape.name, 0,
          "a number of vertices that 1 to " + std::to_string(shape.most_cells) + " cells a side have",
          std::to_string(request.size.vertices.value_or(kDefaultVertices)));
    }
    const auto gap = [&](int n) { return std::fabs(shape.vertices(n) - wanted); };
    while (cells < shape.most_cells && gap(cells + 1) < gap(cells)) ++cells;
  }
  MadeMesh made{shape.build(cells, request), {}};
  made.notes.push_back(std::string(shape.name) + ": " + std::to_string(cells) + " cells a unit, " +
                       std::to_string(made.mesh.points.size()) + " vertices");
  return made;
}

[[noreturn]] void refuse_shape(const std::string& name) {
  std::vector<std::string> names;
  for (const ShapeInfo& shape : list_shapes()) names.push_back(shape.name);
  throw InputError("unknown shape \"" + name + "\"" + nearest_hint(name, names));
}

template <typename Shapes>
auto find_shape(const Shapes& shapes, const std::string& name) {
  const auto found =
      std::find_if(shapes.begin(), shapes.end(), [&](const auto& shape) { return name == shape.name; });
  return found == shapes.end() ? nullptr : &*found;
}

void check_size(const MeshSize& size) {
  if (size.vertices && size.edge_length) {
    throw InputError("mesh size", 0, "a number of vertices or an edge length", "both");
  }
  if (size.edge_length && (!std::isfinite(*size.edge_length) || *size.edge_length <= 0.0)) {
    throw InputError("edge length", 0, "a positive number", short_number(*size.edge_length));
  }
}

std::string ending_of(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending;
}

/// Restores the orientation of foreign tets, and says so.
void restore_orientation(const std::string& where, MeditFile& file) {
  std::size_t turned = 0;
  TetMesh& mesh = file.mesh;
  for (Tet& t : mesh.tets) {
    const auto& p = mesh.points;
    const int sign = orientation(p[t[0]], p[t[1]], p[t[2]], p[t[3]]);
    if (sign == 0) throw InputError(where, 0, "tetrahedra with a volume", "a flat one");
    if (sign > 0) continue;
    std::swap(t[2], t[3]);
    ++turned;
  }
  if (turned > 0)
    file.notes.push_back(std::to_string(turned) + " negatively oriented tetrahedra were turned");
}

}  // namespace

std::vector<ShapeInfo> list_shapes() {
  std::string image_reason;
  std::string body_reason;
  const std::string filled_reason = why_unavailable(kGmshTool);
  for (const MeshTool& tool : {kVtkTool, kSurfaceTool, kGmshTool}) {
    const std::string reason = why_unavailable(tool);
    if (image_reason.empty()) image_reason = reason;
    if (body_reason.empty() && std::string(tool.program) != kVtkTool.program) body_reason = reason;
  }
  std::vector<ShapeInfo> shapes;
  for (const BodyInfo& body : list_bodies())
    shapes.push_back({body.name, body.summary, "mm", body.needs_image ? image_reason : body_reason});
  shapes.insert(
      shapes.end(),
      {{"bean", "a geodesic sphere bent into a kidney with a hilum", "cm", filled_reason},
       {"ball", "the unit ball, a geodesic sphere filled with a finer interior", "1", filled_reason},
       {"filled_bar", "a bar [0, 4] x [0, 1]^2 whose inside is filled without a lattice", "1", filled_reason},
       {"bar", "a bar [0, 4] x [0, 1]^2 of Kuhn cells", "1", ""},
       {"cube", "a cube [0, 1]^3 of Kuhn cells, inner vertices moved at random", "1", ""},
       {"bcc_bar", "a bar [0, 4] x [0, 1]^2 of body-centred cubic lattice", "1", ""}});
  return shapes;
}

std::string shape_complaint(const ShapeRequest& request) {
  const bool is_lattice = find_shape(kLatticeShapes, request.name) != nullptr;
  const bool is_flat = is_lattice || request.name == "filled_bar";
  if (request.jitter && request.name != "cube") {
    return request.name + ": expected no jitter (it is the cube's), found " + short_number(*request.jitter);
  }
  if (request.seed != 0 && is_flat && request.name != "cube") {
    return request.name +
           ": expected no seed (nothing of it is random: its skin is flat and regular), found " +
           std::to_string(request.seed);
  }
  if (request.skin == SkinKind::kCoarse || (request.skin == SkinKind::kFine && !is_lattice)) return "";
  const std::string found = std::string(", found ") + kSkinKinds.of(request.skin);
  if (is_lattice)
    return request.name + ": expected no skin (it is a lattice, whose skin goes with its cells)" + found;
  return is_flat ? request.name + ": expected coarse or fine (voxels would round its edges)" + found : "";
}

std::string shape_key(const ShapeRequest& request) {
  std::array<char, 64> edge{};
  std::snprintf(edge.data(), edge.size(), "%a", request.size.edge_length.value_or(0.0));
  const std::string skin_key =
      request.skin == SkinKind::kCoarse ? "" : std::string("; ") + kSkinKinds.of(request.skin) + " skin";
  return "shape " + request.name + "; vertices " + std::to_string(request.size.vertices.value_or(0)) +
         "; edge " + edge.data() + skin_key +
         (request.seed > 0 ? "; seed " + std::to_string(request.seed) : "") +
         (is_body(request.name) ? body_data_key(request.name) : "");
}

MadeMesh make_shape(const ShapeRequest& request) {
  check_size(request.size);
  const LatticeShape* lattice = find_shape(kLatticeShapes, request.name);
  const FilledShape* shape = find_shape(kFilledShapes, request.name);
  if (lattice == nullptr && shape == nullptr && !is_body(request.name)) refuse_shape(request.name);
  const std::string complaint = shape_complaint(request);
  if (!complaint.empty()) throw InputError(complaint);
  if (lattice != nullptr) return make_lattice(*lattice, request);
  return make_cached(shape_key(request),
                     [&] { return shape != nullptr ? make_filled(*shape, request) : make_body(request); });
}

bool is_surface_file(const std::filesystem::path& path) {
  const std::string ending = ending_of(path);
  return ending == ".stl" || ending == ".off" || ending == ".obj" || ending == ".ply";
}

bool is_mesh_file(const std::filesystem::path& path) {
  const std::string ending = ending_of(path);
  return ending == ".mesh" || ending == ".msh" || ending == ".vtk" || ending == ".vtu";
}

MadeMesh mesh_surface(const SurfaceRequest& request) {
  check_size(request.size);
  if (!is_surface_file(request.file)) {
    throw InputError(request.file.string(), 0, "a surface in .stl, .off, .obj or .ply",
                     "\"" + ending_of(request.file) + "\"");
  }
  const ScratchFolder scratch;
  const char* how = request.repair ? "cgal.repair_surface" : "cgal.read_surface";
  const MeshTool& tool = request.repair ? kRepairTool : kSurfaceTool;
  ToolCall call = bounded_reading(how, request.file, scratch.file("surface.off"));
  call.timeout_s += 600.0;  // more than reading: it is checked against itself, or mended
  const nlohmann::json response = run_tool(tool, call);
  const SurfaceMesh surface = read_off(scratch.file("surface.off"));
  check_fillable(request.file.string(), surface);
  if (request.unit_m) {
    const BoundingBox box = bounding_box(surface.points);
    require_body_size(*request.unit_m * length(box.high - box.low));
  }
  MadeMesh made;
  made.notes = response.value("notes", std::vector<std::string>{});
  FilledSurface filled;
  if (request.size.vertices) {
    check_vertex_count("mesh size", *request.size.vertices);
    filled = fill_user_surface(surface, *request.size.vertices, made.notes);
  } else {
    const double interior = request.size.edge_length.value_or(mean_edge(surface));
    check_interior_size(enclosed_volume(surface), interior);
    filled = fill_surface(surface, interior);
  }
  made.notes.push_back(describe("filled", filled));
  made.mesh = std::move(filled.mesh);
  return made;
}

MadeMesh mesh_surface_cached(const SurfaceRequest& request) {
  ShapeRequest named;
  named.name = "surface " + hash_file(request.file);
  std::error_code error;
  if (request.repair && std::filesystem::is_regular_file(tool_path(kRepairTool), error))
    named.name += " repaired by " + hash_file(tool_path(kRepairTool));
  named.size = request.size;
  return make_cached(shape_key(named), [&] { return mesh_surface(request); });
}

namespace {

MeditFile read_any_mesh(const std::filesystem::path& path, ReadOrientation orientation) {
  const std::string ending = ending_of(path);
  if (!is_mesh_file(path))
    throw InputError(path.string(), 0, "a mesh in .mesh, .msh, .vtk or .vtu", "\"" + ending + "\"");
  refuse_no_file(path, "a mesh file");
  if (ending == ".mesh") return read_medit(path, orientation);
  const bool is_msh = ending == ".msh";
  if (!std::filesystem::is_regular_file(path)) throw InputError(path.string(), 0, "a readable file", "none");
  if (std::filesystem::file_size(path) == 0) throw InputError(path.string(), 0, "a mesh", "an empty file");
  const ScratchFolder scratch;
  const ToolCall call = bounded_reading(is_msh ? "gmsh.read" : "vtk.read", path, scratch.file("read.mesh"));
  const nlohmann::json response = run_tool(is_msh ? kGmshTool : kVtkTool, call);
  MeditFile file;
  try {
    file = read_medit(call.output, ReadOrientation::kKeep);
  } catch (const InputError& error) {  // says where in the converted file; the user has the other one
    const std::string what = error.what();
    throw InputError(path.string() + what.substr(std::min(what.find(": "), what.size())));
  }
  file.notes = response.at("notes").get<std::vector<std::string>>();
  if (orientation == ReadOrientation::kRestore) {
    const std::size_t isolated = remove_isolated_vertices(file.mesh);
    file.isolated_vertices = isolated;
    if (isolated > 0) {
      file.notes.push_back((isolated == 1
                                ? std::string("1 vertex that no tetrahedron uses was")
                                : std::to_string(isolated) + " vertices that no tetrahedron uses were") +
                           " left out");
    }
    restore_orientation(path.string(), file);
  }
  return file;
}

}  // namespace

MeditFile read_mesh(const std::filesystem::path& path, ReadOrientation orientation) {
  MeditFile file = read_any_mesh(path, orientation);
  const std::string complaint = doubled_points_complaint(file.mesh);
  if (!complaint.empty()) throw InputError(path.string(), 0, "tetrahedra that share vertices", complaint);
  return file;
}

void write_mesh(const std::filesystem::path& path, const TetMesh& mesh) {
  const std::string ending = ending_of(path);
  if (ending == ".mesh") return write_medit(path, mesh);
  if (ending != ".vtu")
    throw InputError(path.string(), 0, "a mesh to write in .mesh or .vtu", "\"" + ending + "\"");
  const ScratchFolder scratch;
  write_medit(scratch.file("mesh.mesh"), mesh);
  // Written aside and copied as a whole, so that a full disk leaves what was there.
  const ToolCall call{"convert", "vtk.write", scratch.file("mesh.mesh"), scratch.file("mesh.vtu"), {}, 600.0};
  run_tool(kVtkTool, call);
  const auto bytes = read_bytes(call.output);
  if (!bytes) throw UnavailableError("the tool that writes .vtu left no file that can be read");
  write_file_atomically(path, *bytes);
}

}  // namespace palpate::experiments

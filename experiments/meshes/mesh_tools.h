// The mesh programs (CGAL, gmsh, VTK) as functions: request file, child process, response file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "experiments/files/scratch_folder.h"

namespace palpate::experiments {

/// A mesh program, and the Debian package that it is built with.
struct MeshTool {
  const char* program;
  const char* package;
};

inline constexpr MeshTool kGmshTool{"palpate_gmsh", "libgmsh-dev"};
inline constexpr MeshTool kSurfaceTool{"palpate_cgal_surface", "libcgal-dev"};
inline constexpr MeshTool kRepairTool{"palpate_cgal_repair", "libcgal-dev"};
inline constexpr MeshTool kVtkTool{"palpate_vtk", "libvtk9-dev"};

/// One call of a mesh program.
struct ToolCall {
  std::string contest;  ///< "mesh" or "convert"
  std::string method;
  std::filesystem::path input;
  std::filesystem::path output;
  nlohmann::json options = nlohmann::json::object();
  double timeout_s = 300.0;
  std::uint64_t memory_bytes = 0;  ///< of the program; 0: no bound
};

/// A file that a user brings, to be read by a vendor's library: bounded in time and memory by its size, since
/// a damaged one may ask for anything. 60 s and a second a MiB; 2 GiB and 64 bytes a byte.
ToolCall bounded_reading(const std::string& method, const std::filesystem::path& input,
                         const std::filesystem::path& output);

/// Where a tool's program is. It need not exist.
std::filesystem::path tool_path(const MeshTool& tool);

/// Empty, or why the tool cannot run here.
std::string why_unavailable(const MeshTool& tool);

/// Calls a mesh program and returns its whole response.
/// Throws: InputError with the program's own line if it refuses its input, and if it crashes, hangs or runs
///         out of its bounds on a file that a user brought ("convert"); UnavailableError if it is not built,
///         and if it does so at other work, fails, or answers without leaving the output file.
nlohmann::json run_tool(const MeshTool& tool, const ToolCall& call);

}  // namespace palpate::experiments

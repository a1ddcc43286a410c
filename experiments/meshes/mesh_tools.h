// The programs that make meshes (CGAL, gmsh, VTK) and springs as functions: request file, child process,
// response file.
#pragma once

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "experiments/files/scratch_folder.h"

namespace palpate::experiments {

/// A program, and the Debian package that it is built with.
struct MeshTool {
  const char* program;
  const char* package;  ///< empty: none
};

inline constexpr MeshTool kGmshTool{"palpate_gmsh", "libgmsh-dev"};
inline constexpr MeshTool kSurfaceTool{"palpate_cgal_surface", "libcgal-dev"};
inline constexpr MeshTool kRepairTool{"palpate_cgal_repair", "libcgal-dev"};
inline constexpr MeshTool kVtkTool{"palpate_vtk", "libvtk9-dev"};
inline constexpr MeshTool kSpringsTool{"palpate_springs", ""};

/// A bound for work that may take as long as it likes.
inline constexpr double kAnyLongTime = 1e8;  // s

/// One call of a program.
struct ToolCall {
  std::string contest;  ///< "mesh", "convert", "springs" or "training"
  std::string method;
  std::filesystem::path input;
  std::filesystem::path output;
  nlohmann::json options = nlohmann::json::object();
  double timeout_s = 300.0;
  std::uint64_t memory_bytes = 0;                         ///< of the program; 0: no bound
  std::filesystem::path standard_output{};                ///< file that receives it; empty: discarded
  std::function<void()> while_waiting{};                  ///< called some ten times a second; may be empty
  const volatile std::sig_atomic_t* stop_flag = nullptr;  ///< it is killed when it turns non-zero
};

/// A file that a user brings, to be read by a vendor's library: bounded in time and memory by its size, since
/// a damaged one may ask for anything. 60 s and a second a MiB; 2 GiB and 64 bytes a byte.
ToolCall bounded_reading(const std::string& method, const std::filesystem::path& input,
                         const std::filesystem::path& output);

/// Where a tool's program is. It need not exist.
std::filesystem::path tool_path(const MeshTool& tool);

/// Empty, or why the tool cannot run here.
std::string why_unavailable(const MeshTool& tool);

/// Calls a program and returns its whole response.
/// Throws: InputError with the program's own line if it refuses its input, and if it crashes, hangs or runs
///         out of its bounds on a file that a user brought ("convert"); UnavailableError if it is not built,
///         and if it does so at other work, fails, or answers without leaving the output file.
nlohmann::json run_tool(const MeshTool& tool, const ToolCall& call);

}  // namespace palpate::experiments

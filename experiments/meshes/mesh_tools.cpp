#include "experiments/meshes/mesh_tools.h"

#include <unistd.h>

#include <algorithm>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "experiments/files/places.h"
#include "experiments/files/plain_file.h"
#include "experiments/processes/process.h"
#include "experiments/processes/program_output.h"
#include "reference/door/contest_files.h"
#include "reference/door/json_file.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

constexpr std::uint64_t kMiB = std::uint64_t{1} << 20U;

json read_response(const std::filesystem::path& path) {
  if (!is_plain_file(path)) return {};
  json value = reference::read_json_file(path);
  return value.is_object() ? value : json{};
}

std::string text_of(const json& response, const char* key) {
  return response.contains(key) && response[key].is_string() ? response[key].get<std::string>() : "";
}

/// The request as text. Throws: InputError if the file has a name that JSON cannot hold.
std::string utf8_dump(const json& request, const std::filesystem::path& input) {
  try {
    return request.dump();
  } catch (const json::exception&) {
    throw InputError("a file: expected a path in UTF-8, found \"" +
                     json(input.string()).dump(-1, ' ', true, json::error_handler_t::replace) + "\"");
  }
}

/// Whether a program did not come to an end of its own: it crashed, or ran out of its bounds.
bool gave_up(const ProcessResult& result, const std::string& message) {
  constexpr int kError = 3;  // of adapters that say what is wrong
  if (result.end == ProcessEnd::kNotStarted || result.end == ProcessEnd::kInterrupted) return false;
  return result.end != ProcessEnd::kExited || result.exit_code != kError ||
         message.find("bad_alloc") != std::string::npos;
}

}  // namespace

std::filesystem::path tool_path(const MeshTool& tool) {
  return std::filesystem::path(program_folder()) / tool.program;
}

std::string why_unavailable(const MeshTool& tool) {
  if (::access(tool_path(tool).c_str(), X_OK) == 0) {
    const std::string library = missing_library(tool_path(tool));
    if (library.empty()) return "";
    return std::string(tool.program) + " lacks the shared library " + library +
           ", of a package that palpate recommends";
  }
  const std::string package = tool.package;
  return std::string(tool.program) + " is not built" +
         (package.empty() ? "" : ": install the package " + package + " and configure again");
}

ToolCall bounded_reading(const std::string& method, const std::filesystem::path& input,
                         const std::filesystem::path& output) {
  constexpr double kLeastSeconds = 60.0;
  constexpr std::uint64_t kLeastMemory = 2048 * kMiB;
  constexpr std::uint64_t kMemoryPerByte = 64;
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(input, error);
  ToolCall call{"convert", method, input, output, json::object(), kLeastSeconds, kLeastMemory};
  if (error) return call;
  if (size > kLargestFile)
    throw InputError(input.string(), 0, "a file of at most " + std::to_string(kLargestFile) + " bytes",
                     std::to_string(size));
  call.timeout_s += static_cast<double>(size) / static_cast<double>(kMiB);
  call.memory_bytes += kMemoryPerByte * size;
  return call;
}

json run_tool(const MeshTool& tool, const ToolCall& call) {
  const std::string reason = why_unavailable(tool);
  if (!reason.empty()) throw UnavailableError(reason);
  const ScratchFolder scratch;
  const json request{{"schema", "palpate/request/1"},
                     {"contest", call.contest},
                     {"method", call.method},
                     {call.contest == "mesh" ? "surface_in" : "mesh_in", call.input.string()},
                     {reference::contest_files(call.contest).output_key, call.output.string()},
                     {"options", call.options},
                     {"threads", 1}};
  write_file_atomically(scratch.file("request.json"), utf8_dump(request, call.input));
  ProcessSpec spec;
  spec.arguments = {tool_path(tool).string(), scratch.file("request.json").string(),
                    scratch.file("response.json").string()};
  spec.timeout_s = call.timeout_s;
  spec.memory_bytes = call.memory_bytes;
  spec.file_bytes = kLargestFile;
  spec.standard_error = scratch.file("stderr.txt");
  spec.standard_output = call.standard_output;
  spec.while_waiting = call.while_waiting;
  spec.stop_flag = call.stop_flag;
  const ProcessResult result = run_process(spec);
  json response = read_response(scratch.file("response.json"));
  const std::string status = text_of(response, "status");
  if (result.end == ProcessEnd::kExited && status == "bad_input") {
    throw InputError(text_of(response, "message"));
  }
  if (result.end == ProcessEnd::kExited && result.exit_code == 0 && status == "ok" &&
      is_plain_file(call.output)) {
    return response;
  }
  const std::string message = status == "error" ? text_of(response, "message") : result.message;
  if (call.contest == "convert" && call.memory_bytes > 0 && gave_up(result, message))
    throw InputError(call.input.string(), 0,
                     "a file that " + std::string(tool.program) + " can read in " +
                         short_number(call.timeout_s) + " s and " + std::to_string(call.memory_bytes / kMiB) +
                         " MiB",
                     "one on which it gave up (" + message + ")");
  throw UnavailableError(std::string(tool.program) + " (" + call.method + "): " + message);
}

}  // namespace palpate::experiments

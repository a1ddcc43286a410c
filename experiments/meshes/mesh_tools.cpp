#include "experiments/meshes/mesh_tools.h"

#include <unistd.h>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "experiments/files/places.h"
#include "experiments/processes/process.h"
#include "reference/door/json_file.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

json read_response(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path)) return {};
  json value = reference::read_json_file(path);
  return value.is_object() ? value : json{};
}

std::string text_of(const json& response, const char* key) {
  return response.contains(key) && response[key].is_string() ? response[key].get<std::string>() : "";
}

}  // namespace

std::filesystem::path tool_path(const MeshTool& tool) {
  return std::filesystem::path(program_folder()) / tool.program;
}

std::string why_unavailable(const MeshTool& tool) {
  if (::access(tool_path(tool).c_str(), X_OK) == 0) return "";
  return std::string(tool.program) + " is not built: install the package " + tool.package +
         " and configure again";
}

json run_tool(const MeshTool& tool, const ToolCall& call) {
  const std::string reason = why_unavailable(tool);
  if (!reason.empty()) throw UnavailableError(reason);
  const ScratchFolder scratch;
  const json request{{"schema", "palpate/request/1"},
                     {"contest", call.contest},
                     {"method", call.method},
                     {call.contest == "mesh" ? "surface_in" : "mesh_in", call.input.string()},
                     {"mesh_out", call.output.string()},
                     {"options", call.options},
                     {"threads", 1}};
  write_file_atomically(scratch.file("request.json"), request.dump());
  ProcessSpec spec;
  spec.arguments = {tool_path(tool).string(), scratch.file("request.json").string(),
                    scratch.file("response.json").string()};
  spec.timeout_s = call.timeout_s;
  const ProcessResult result = run_process(spec);
  json response = read_response(scratch.file("response.json"));
  const std::string status = text_of(response, "status");
  if (result.end == ProcessEnd::kExited && status == "bad_input") {
    throw InputError(text_of(response, "message"));
  }
  if (result.end == ProcessEnd::kExited && result.exit_code == 0 && status == "ok" &&
      std::filesystem::exists(call.output)) {
    return response;
  }
  const std::string message = status == "error" ? text_of(response, "message") : result.message;
  throw UnavailableError(std::string(tool.program) + " (" + call.method + "): " + message);
}

}  // namespace palpate::experiments

#include "experiments/processes/report_script.h"

#include "core/base/error.h"
#include "experiments/files/places.h"
#include "experiments/files/plain_file.h"
#include "experiments/processes/stop_signals.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {

ProcessSpec report_script(const std::string& name, const std::vector<std::string>& arguments) {
  const std::filesystem::path script = std::filesystem::path(source_folder()) / "report" / name;
  if (!std::filesystem::exists(script)) throw UnavailableError("the report is missing: " + script.string());
  ProcessSpec spec;
  // Its output goes through a file: only this process knows how wide the terminal is.
  spec.arguments = {"/usr/bin/env", "COLUMNS=" + std::to_string(output_columns()), "/usr/bin/python3", "-B",
                    script.string()};
  spec.arguments.insert(spec.arguments.end(), arguments.begin(), arguments.end());
  spec.timeout_s = 1800.0;
  spec.stop_flag = catch_stop_signals();
  return spec;
}

ProcessSpec page_script(const std::string& name, std::vector<std::string> arguments) {
  arguments.emplace_back("--scripts");
  arguments.push_back(page_folder().string());
  return report_script(name, arguments);
}

ScriptAnswer run_script(ProcessSpec spec, const ScratchFolder& scratch, const std::string& what) {
  spec.standard_output = scratch.file("out");
  spec.standard_error = scratch.file("error");
  const ProcessResult result = run_process(spec);
  if (result.end == ProcessEnd::kInterrupted) return {130, ""};
  if (result.end == ProcessEnd::kExited && result.exit_code == 2)
    throw InputError(last_line(spec.standard_error));
  if (result.end != ProcessEnd::kExited || result.exit_code > 1)
    throw UnavailableError(what + " failed (" + result.message + "): " + last_line(spec.standard_error));
  return {result.exit_code, read_bytes(spec.standard_output).value_or("")};
}

std::string last_line(const std::filesystem::path& file) {
  std::string text = read_bytes(file).value_or("");
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text.substr(text.rfind('\n') + 1);
}

}  // namespace palpate::experiments

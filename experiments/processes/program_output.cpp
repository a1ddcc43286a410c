#include "experiments/processes/program_output.h"

#include "experiments/files/file_bytes.h"
#include "experiments/files/scratch_folder.h"
#include "experiments/processes/process.h"

namespace palpate::experiments {

std::string program_output(const std::vector<std::string>& arguments) {
  const ScratchFolder scratch;
  ProcessSpec spec;
  spec.arguments = arguments;
  spec.timeout_s = 20.0;
  spec.standard_output = scratch.file("output");
  const ProcessResult result = run_process(spec);
  const std::string text = read_bytes(spec.standard_output).value_or("");
  return result.end == ProcessEnd::kExited && result.exit_code == 0 ? text : "";
}

}  // namespace palpate::experiments

#include "experiments/grading/graded_mesh.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/mesh/io/medit.h"
#include "core/simplify/sizing/size_file.h"
#include "core/simplify/sizing/stop_rule.h"
#include "experiments/files/output_file.h"
#include "experiments/files/scratch_folder.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

constexpr double kGraderTimeout = 3600.0;  // s

TetMesh in_unit(TetMesh mesh, double factor) {
  for (Vec3& point : mesh.points) point = factor * point;
  return mesh;
}

}  // namespace

nlohmann::json resolve_simplifier_options(const MethodSpec& method,
                                          const std::map<std::string, GivenOption>& given) {
  nlohmann::json options = resolve_options(method, given);
  if (method.find_option("unit_m") != nullptr && given.count("unit_m") == 0)
    options["unit_m"] = kSimplifierUnitM;
  return options;
}

std::uint64_t tets_after(const Stop& stop, std::uint64_t tets) {
  if (stop.kind == StopKind::kTets) return static_cast<std::uint64_t>(stop.value);
  if (stop.kind != StopKind::kRatio)
    throw InputError("grade", 0, "a stop by tets or by ratio", stop_name(stop.kind));
  simplify::StopRule rule;
  rule.ratio = stop.value;
  return std::max<std::uint64_t>(1, simplify::target_tet_count(rule, tets));
}

GradedMesh make_graded_mesh(const GradeWish& wish, const GradedBody& body, const MethodEntry& simplifier,
                            const std::map<std::string, GivenOption>& options, const Stop& stop,
                            const PilotSetting& setting) {
  const MethodSpec& method = *simplifier.method;
  if (method.find_option("sizes") == nullptr)
    throw InputError("--method", 0, "a method that takes sizes, such as palpate.refined or palpate.surface",
                     method.name);
  GradedMesh graded;
  graded.wanted = find_graded_sizes(wish, body, tets_after(stop, body.mesh.tets.size()), setting);
  graded.failure = graded.wanted.failure;
  if (!graded.failure.empty()) return graded;
  create_folder(setting.folder);
  const ScratchFolder scratch;
  ContestantTask task;
  task.method = simplifier;
  task.scratch = scratch.path();
  task.mesh_in = scratch.file("in.mesh");
  write_medit(task.mesh_in, in_unit(body.mesh, 1.0 / kSimplifierUnitM));
  const fs::path sizes = scratch.file("sizes.csv");
  simplify::write_sizes(sizes, graded.wanted.sizes);
  task.options = resolve_simplifier_options(method, options);
  if (!wish.near.empty() || !wish.pilot.empty()) task.options["sizes"] = sizes.string();
  task.stop = stop;
  task.threads = setting.threads;
  task.timeout_s = kGraderTimeout;
  task.stop_flag = setting.stop_flag;
  const ContestantAnswer answer = run_contestant(task);
  if (answer.outcome == "bad_input") throw InputError(method.name + ": " + answer.message);
  if (answer.outcome != "ok") {
    graded.failure = method.name + ": " + answer.outcome + ": " + answer.message;
    return graded;
  }
  graded.report = answer.report;
  graded.kernel_s = answer.kernel_s;
  graded.notes = answer.notes;
  graded.mesh = in_unit(read_medit(answer.output, ReadOrientation::kKeep).mesh, kSimplifierUnitM);
  return graded;
}

}  // namespace palpate::experiments

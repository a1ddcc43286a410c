#include "experiments/contests/contest.h"

#include "core/mesh/geometry.h"

namespace palpate::experiments {

WorkBounds judge_bounds(const Plan& plan, const volatile std::sig_atomic_t* stop_flag) {
  return {plan.run.judge_timeout_s, plan.run.judge_memory_mib << 20U, stop_flag};
}

nlohmann::json mesh_facts(const std::string& name, const TetMesh& mesh, const std::string& hash) {
  return {{"name", name},
          {"vertices", mesh.points.size()},
          {"tets", mesh.tets.size()},
          {"hash", hash},
          {"ideal_volume", total_volume(mesh) / static_cast<double>(mesh.tets.size())}};
}

void require_going_on(const ContestSetting& setting) {
  if (setting.stop_flag != nullptr && *setting.stop_flag != 0) throw RunInterrupted();
}

ContestantTask start_task(const std::string& method, const std::filesystem::path& mesh,
                          const ContestSetting& setting) {
  ContestantTask task;
  task.method = *setting.registry.find(method);
  task.mesh_in = mesh;
  task.scratch = std::filesystem::absolute(setting.folder.fresh_scratch());
  task.threads = setting.threads;
  task.stop_flag = setting.stop_flag;
  return task;
}

}  // namespace palpate::experiments

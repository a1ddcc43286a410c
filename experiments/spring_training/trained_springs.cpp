#include "experiments/spring_training/trained_springs.h"

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/mesh/io/medit.h"
#include "experiments/files/file_cache.h"
#include "experiments/files/file_hash.h"
#include "experiments/files/output_file.h"
#include "experiments/meshes/mesh_tools.h"
#include "experiments/scene_reader/scene_problem.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

constexpr const char* kSchema = "palpate/trained/1";

/// All that the answer depends on: plan, mesh, and the programs that solve and fit.
json key_of(const fs::path& plan_file, const TrainingPlan& plan, const TrainingSetting& setting) {
  json key = {{"training", hash_file(plan_file)}, {"palpate", hash_file("/proc/self/exe")}};
  if (why_unavailable(kSpringsTool).empty()) key["programs"]["springs"] = hash_file(tool_path(kSpringsTool));
  for (const char* method : {"fem.p2", "fem.p1"}) {
    const auto entry = setting.registry.find(method);
    if (entry && entry->contestant->unavailable().empty())
      key["programs"][method] = hash_contestant(*entry->contestant);
  }
  fs::create_directories(setting.scratch);
  const fs::path mesh = setting.scratch / "training.mesh";
  write_medit(mesh, build_scene_mesh(plan.mesh).mesh);
  key["mesh"] = hash_file(mesh);
  return key;
}

/// What an earlier run left, or nothing if there is none or it is damaged.
std::optional<TrainedSprings> load(const fs::path& folder, const json& key) {
  const json kept = read_kept(folder / "trained.json");
  if (!kept.is_object() || kept.value("schema", "") != kSchema || kept.value("key", json()) != key) return {};
  TrainedSprings trained{folder / "springs.csv", {}, kept.value("report", json())};
  std::error_code error;
  const json files = kept.value("files", json::object());
  for (const auto& [name, hash] : files.items()) {
    if (!fs::is_regular_file(folder / name, error) || hash_file(folder / name) != hash) return {};
    if (name == "moduli.csv") trained.moduli = folder / name;
  }
  return trained;
}

}  // namespace

TrainedSprings train_cached(const fs::path& plan_file, const TrainingSetting& setting) {
  const TrainingPlan plan = read_training_plan(plan_file);
  const json key = key_of(plan_file, plan, setting);
  const fs::path folder = cache_entry("trained", key.dump());
  if (auto kept = load(folder, key)) return *std::move(kept);
  create_folder(folder);
  TrainedSprings trained{folder / "springs.csv", {}, {}};
  if (plan.volume != TrainedVolume::kNone) trained.moduli = folder / "moduli.csv";
  trained.report = run_training(plan, setting, {trained.springs, trained.moduli});
  json files = {{"springs.csv", hash_file(trained.springs)}};
  if (!trained.moduli.empty()) files["moduli.csv"] = hash_file(trained.moduli);
  const json kept = {{"schema", kSchema}, {"key", key}, {"files", files}, {"report", trained.report}};
  write_file_atomically(folder / "trained.json", kept.dump(2) + "\n");
  return trained;
}

}  // namespace palpate::experiments

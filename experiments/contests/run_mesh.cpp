#include "experiments/contests/run_mesh.h"

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "experiments/files/file_hash.h"
#include "experiments/judging/judge_record.h"
#include "experiments/meshes/mesh_source.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

nlohmann::json describe_source(const PlanMesh& plan_mesh) {
  if (!plan_mesh.shape) {
    return {{"file", plan_mesh.file.filename().string()}, {"hash", hash_file(plan_mesh.file)}};
  }
  const ShapeRequest& shape = *plan_mesh.shape;
  nlohmann::json source = {{"make", shape.name}, {"seed", shape.seed}};
  if (shape.size.vertices) source["vertices"] = *shape.size.vertices;
  if (shape.size.edge_length) source["edge_length"] = *shape.size.edge_length;
  if (shape.jitter) source["jitter"] = *shape.jitter;
  if (shape.skin != SkinKind::kCoarse) source["skin"] = kSkinKinds.of(shape.skin);
  return source;
}

void measure(RunMesh& mesh) {
  mesh.hash = hash_file(mesh.file);
  mesh.ideal_volume = total_volume(mesh.mesh) / static_cast<double>(mesh.mesh.tets.size());
}

}  // namespace

RunMesh obtain_mesh(const PlanMesh& plan_mesh, const fs::path& file) {
  RunMesh mesh;
  mesh.name = plan_mesh.name;
  mesh.file = file;
  if (plan_mesh.shape) {
    MadeMesh made = make_shape(*plan_mesh.shape);
    mesh.mesh = std::move(made.mesh);
    mesh.notes = std::move(made.notes);
  } else {
    MeditFile read;
    try {
      read = read_mesh(plan_mesh.file);
      const Judgement judgement = judge_mesh(read.mesh);
      if (!judgement.violations.empty())
        throw InputError(plan_mesh.file.string(), 0, "a valid mesh", judgement.violations.front());
    } catch (const NoRoomError&) {
      throw;
    } catch (const InputError& error) {
      throw InputError(plan_mesh.where + ": mesh " + plan_mesh.name + ": " + error.what());
    }
    mesh.mesh = std::move(read.mesh);
    mesh.notes = std::move(read.notes);
  }
  std::error_code error;
  fs::create_directories(file.parent_path(), error);
  if (error) throw InputError(file.string(), 0, "a folder that can be written", error.message());
  write_mesh(file, mesh.mesh);
  mesh.source = describe_source(plan_mesh);
  measure(mesh);
  return mesh;
}

RunMesh reload_mesh(const PlanMesh& plan_mesh, const fs::path& file, const nlohmann::json& provenance) {
  RunMesh mesh;
  mesh.name = plan_mesh.name;
  mesh.file = file;
  mesh.mesh = read_mesh(file).mesh;
  measure(mesh);
  for (const nlohmann::json& entry : provenance.value("meshes", nlohmann::json::array())) {
    if (entry.value("name", "") != mesh.name) continue;
    if (entry.value("hash", "") == mesh.hash) return mesh;
    throw InputError(file.string(), 0, "the mesh that the run started with (" + entry.value("hash", "") + ")",
                     mesh.hash);
  }
  throw InputError(file.string() + ": the run's provenance does not name this mesh");
}

nlohmann::json describe_mesh(const RunMesh& mesh) {
  return {{"name", mesh.name},
          {"source", mesh.source},
          {"vertices", mesh.mesh.points.size()},
          {"tets", mesh.mesh.tets.size()},
          {"hash", mesh.hash},
          {"ideal_volume", mesh.ideal_volume},
          {"notes", mesh.notes}};
}

nlohmann::json prepare_meshes(const ContestSetting& setting, const nlohmann::json& earlier,
                              std::vector<RunMesh>& meshes) {
  nlohmann::json described = nlohmann::json::array();
  for (const PlanMesh& mesh : setting.plan.meshes) {
    require_going_on(setting);
    const fs::path file = setting.folder.paths().mesh(mesh.name + "/input");
    if (!earlier.is_null()) {
      meshes.push_back(reload_mesh(mesh, file, earlier));
      continue;
    }
    setting.progress.show("mesh " + mesh.name);
    meshes.push_back(obtain_mesh(mesh, file));
    for (const std::string& note : meshes.back().notes) {
      const bool named = note.rfind(mesh.name + ":", 0) == 0;
      setting.progress.say(named ? note : mesh.name + ": " + note);
    }
    described.push_back(describe_mesh(meshes.back()));
  }
  return earlier.is_null() ? nlohmann::json{{"meshes", described}} : nlohmann::json::object();
}

}  // namespace palpate::experiments

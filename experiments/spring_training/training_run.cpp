#include "experiments/spring_training/training_run.h"

#include <array>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/mesh/io/medit.h"
#include "experiments/contestants/solution.h"
#include "experiments/files/plain_file.h"
#include "experiments/files/problem_folder.h"
#include "experiments/meshes/mesh_tools.h"
#include "experiments/scene_reader/scene_problem.h"
#include "experiments/spring_training/identified_springs.h"
#include "reference/door/deform_problem.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

/// Solves a problem with finite elements. Returns: the file of the displacement.
std::string solve_field(const std::string& name, const ProblemPaths& files, const std::string& method,
                        int refine, const TrainingSetting& setting) {
  ContestantTask task;
  task.method = *setting.registry.find(method);
  task.mesh_in = files.mesh;
  task.problem_in = files.problem;
  task.scratch = files.mesh.parent_path() / method;
  fs::create_directories(task.scratch);
  task.options = resolve_options(*task.method.method, {});
  task.options["refine"] = refine;
  task.threads = setting.threads;
  task.timeout_s = kReferenceTimeout;
  task.stop_flag = setting.stop_flag;
  const Solution solution = solve(task, "converged");
  if (solution.interrupted) throw RunInterrupted();
  if (!solution.failure.empty())
    throw UnavailableError(method + " on the training case " + name + " " + solution.failure);
  return fs::absolute(solution.answer.output).string();
}

void require_programs(const Registry& registry) {
  for (const char* name : {"fem.p2", "fem.p1"}) {
    const auto method = registry.find(name);
    if (!method)
      throw UnavailableError(std::string("training needs the contestant ") + name + ", which is not there");
    const std::string why = method->contestant->unavailable();
    if (!why.empty())
      throw UnavailableError(std::string("training needs ") + name + ", which is unavailable: " + why);
  }
  const std::string why = why_unavailable(kSpringsTool);
  if (!why.empty()) throw UnavailableError("training needs the springs' program: " + why);
}

/// Estimates the seconds that are left from those gone by.
class StepClock {
 public:
  explicit StepClock(std::size_t steps) : steps_(steps) {}

  /// After another step.
  double seconds_left() {
    ++done_;
    return watch_.seconds() / static_cast<double>(done_) * static_cast<double>(steps_ - done_);
  }

 private:
  Stopwatch watch_;
  std::size_t steps_;
  std::size_t done_ = 0;
};

/// A case that is to be solved.
struct PlacedCase {
  std::size_t split;
  std::string name;
  BoundaryProblem problem;
};

/// All problems before the first is solved: what is wrong with one is said before hours of solving. Gives
/// `splits` the names of the sets.
std::vector<PlacedCase> place_cases(const TrainingPlan& plan, const TetMesh& mesh, json& splits) {
  std::vector<PlacedCase> places;
  const std::array<const TrainingSplit*, 4> wanted{&plan.train, &plan.validate, &plan.test_loads,
                                                   &plan.test_clamps};
  for (const TrainingSplit* split : wanted) {
    for (const TrainingPair& pair : split->cases)
      places.push_back({splits.size(), plan.clamps[pair.clamp].name + "/" + plan.loads[pair.load].name,
                        place_case(plan, pair.clamp, pair.load, mesh)});
    splits.push_back({{"name", split->name}, {"cases", json::array()}});
  }
  return places;
}

/// The sets with their cases, solved, as a request of the contest training has them.
json solve_splits(const TrainingPlan& plan, const TetMesh& mesh, const TrainingSetting& setting) {
  json splits = json::array();
  const std::vector<PlacedCase> places = place_cases(plan, mesh, splits);
  setting.progress.start(places.size());
  StepClock clock(places.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    const PlacedCase& place = places[i];
    setting.progress.show("field of " + place.name);
    const ProblemPaths files = write_problem_folder(mesh, reference::problem_to_json(place.problem),
                                                    setting.scratch / std::to_string(i));
    splits[place.split]["cases"].push_back(
        {{"name", place.name},
         {"problem", files.problem.string()},
         {"quadratic", solve_field(place.name, files, "fem.p2", plan.refine, setting)},
         {"linear", solve_field(place.name, files, "fem.p1", 0, setting)}});
    fs::remove(files.mesh);
    setting.progress.step(clock.seconds_left());
  }
  return splits;
}

const char* volume_name(TrainedVolume volume) {
  if (volume == TrainedVolume::kTet) return "tet";
  return volume == TrainedVolume::kNodeAverage ? "node_average" : "none";
}

/// Tells what the program says as it goes: one JSON object a line.
class FitWatch {
 public:
  FitWatch(fs::path file, const TrainingSetting& setting) : file_(std::move(file)), setting_(setting) {}

  /// Reads the lines that have come since.
  void look() {
    const auto bytes = read_bytes(file_);
    if (!bytes) return;
    for (std::size_t end = 0; (end = bytes->find('\n', read_)) != std::string::npos; read_ = end + 1)
      tell(json::parse(bytes->substr(read_, end - read_), nullptr, false));
  }

 private:
  void tell(const json& line) const {
    if (!line.is_object()) return;
    Progress& progress = setting_.progress;
    if (line.contains("note") && setting_.note) setting_.note(line["note"].get<std::string>());
    if (line.contains("fits")) progress.start(line["fits"].get<std::size_t>());
    if (line.contains("now")) progress.show(line["now"].get<std::string>());
    if (line.contains("said")) progress.say(line["said"].get<std::string>());
    if (line.contains("left_s")) progress.step(line["left_s"].get<double>());
  }

  fs::path file_;
  const TrainingSetting& setting_;
  std::size_t read_ = 0;
};

}  // namespace

BoundaryProblem place_case(const TrainingPlan& plan, std::size_t clamp, std::size_t load,
                           const TetMesh& mesh) {
  Scene scene;
  scene.file = plan.file;
  scene.material = plan.material;
  scene.clamps = plan.clamps[clamp].clamps;
  scene.loads = plan.loads[load].loads;
  return build_problem(place_scene(std::move(scene), mesh), mesh);
}

json run_training(const TrainingPlan& plan, const TrainingSetting& setting, const TrainingFiles& files) {
  require_programs(setting.registry);
  const MadeMesh made = build_scene_mesh(plan.mesh);
  fs::create_directories(setting.scratch);
  ToolCall call{"training", springs::spring_method_name(plan.start),
                fs::absolute(setting.scratch / "training.mesh"), fs::absolute(files.springs)};
  write_medit(call.input, made.mesh);
  call.options = {{"material", material_to_json(plan.material)},
                  {"face_opposite", plan.face_opposite},
                  {"calibrate", plan.calibrate},
                  {"volume", volume_name(plan.volume)},
                  {"ridges", plan.ridges},
                  {"iterations", plan.iterations},
                  {"splits", solve_splits(plan, made.mesh, setting)},
                  {"moduli_out", files.moduli.empty() ? "" : fs::absolute(files.moduli).string()}};
  if (setting.note) {
    for (const std::string& note : made.notes) setting.note(note);
  }
  call.timeout_s = kAnyLongTime;
  call.stop_flag = setting.stop_flag;
  call.standard_output = setting.scratch / "fits.jsonl";
  FitWatch watch(call.standard_output, setting);
  call.while_waiting = [&watch] { watch.look(); };
  try {
    const json response = run_tool(kSpringsTool, call);
    watch.look();
    return response.at("report");
  } catch (const UnavailableError&) {
    if (setting.stop_flag != nullptr && *setting.stop_flag != 0) throw RunInterrupted();
    throw;
  }
}

}  // namespace palpate::experiments

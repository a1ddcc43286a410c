// simulate: a scene through the same door as in a plan.
#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/base/stopwatch.h"
#include "core/mesh/io/displacement_vtu.h"
#include "core/mesh/io/medit.h"
#include "core/mesh/topology.h"
#include "experiments/commands/commands.h"
#include "experiments/commands/usage.h"
#include "experiments/contestants/contestant_run.h"
#include "experiments/contests/motion_watch.h"
#include "experiments/contests/moving_task.h"
#include "experiments/envelope/envelope_output.h"
#include "experiments/files/scratch_folder.h"
#include "experiments/processes/stop_signals.h"
#include "experiments/scene_reader/scene.h"
#include "experiments/scene_reader/scene_motion.h"
#include "experiments/scene_reader/scene_problem.h"
#include "experiments/text/terminal.h"
#include "experiments/trials/frozen_choice.h"
#include "reference/door/deform_problem.h"
#include "reference/door/result_folder.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

struct SimulateArguments {
  std::string scene;
  std::string out;
  double timeout_s = 3600.0;
  int threads = 1;
  double most_output_gb = 2.0;
  bool as_json = false;
};

/// Throws: InputError if what an earlier run left in the folder, and goes, is not of such a run, or is what
/// the scene reads: its mesh, or a file of its model.
void require_replaceable_results(const Scene& scene, const fs::path& folder) {
  std::vector<fs::path> inputs{scene.mesh.file, scene.mesh.regions_from};
  if (scene.model) {
    for (const auto& [name, given] : scene.model->set) inputs.emplace_back(given.text);
  }
  for (const fs::path& result : reference::earlier_results(folder)) {
    for (const fs::path& input : inputs) {
      std::error_code none;  // most of a model's options are no files
      if (!input.empty() && fs::equivalent(result, input, none))
        throw InputError("--output", 0, "another folder than that of what the scene reads",
                         result.string() + ", where a result goes");
    }
  }
}

/// The folder for what is written, made before any work is done for it. If nothing is written, what was made
/// for it is taken away again.
class ResultFolder {
 public:
  explicit ResultFolder(const fs::path& folder) {
    std::error_code error;
    for (fs::path part = fs::absolute(folder); !fs::exists(part, error) && part.has_relative_path();
         part = part.parent_path())
      made_.push_back(part);
    fs::create_directories(folder, error);
    if (error || !fs::is_directory(folder))
      throw InputError(folder.string(), 0, "a folder that can be written",
                       error ? error.message() : "a file");
  }
  ~ResultFolder() {
    std::error_code ignored;
    for (const fs::path& part : made_) fs::remove(part, ignored);  // leaves what is not empty
  }
  ResultFolder(const ResultFolder&) = delete;
  ResultFolder& operator=(const ResultFolder&) = delete;

 private:
  std::vector<fs::path> made_;
};

double largest(const std::vector<Vec3>& field) {
  double most = 0.0;
  for (const Vec3& u : field) most = std::max(most, length(u));
  return most;
}

/// The answer as a report; writes the files where there is a displacement.
json write_result(const ContestantAnswer& answer, const std::string& method, const TetMesh& mesh,
                  const fs::path& out) {
  reference::remove_earlier_results(out);
  json report = answer.report;
  report["method"] = method;
  report["kernel_s"] = *answer.kernel_s;
  report["vertices"] = mesh.points.size();
  report["tets"] = mesh.tets.size();
  report["steps"] = answer.report.value("steps", answer.report.value("load_steps", json(1)));
  report["files"] = json::array();
  report["max_displacement_m"] = nullptr;
  if (report.at("outcome") != "converged") return report;
  std::vector<Vec3> field;
  try {
    field = reference::read_displacement(answer.output, mesh.points.size(), build_edges(mesh).size());
  } catch (const InputError& error) {
    throw UnavailableError(method + ": its displacement cannot be read: " + error.what());
  }
  field.resize(mesh.points.size());
  report["max_displacement_m"] = largest(field);
  const fs::path csv = out / "displacement.csv";
  const fs::path vtu = out / "displacement.vtu";
  reference::write_displacement(csv, field);
  write_displacement_vtu(vtu, mesh, field);
  report["files"] = {csv.string(), vtu.string()};
  return report;
}

void print_result(const json& report) {
  TextTable table({"measure", "value"}, "lr");
  table.add({"method", report.at("method").get<std::string>()});
  table.add({"outcome", report.at("outcome").get<std::string>()});
  table.add({"vertices", report.at("vertices").dump()});
  table.add({"tetrahedra", report.at("tets").dump()});
  table.add({"time of the method", time_text(report.at("kernel_s").get<double>())});
  if (report.at("max_displacement_m").is_number())
    table.add({"largest displacement",
               short_number(1000.0 * report.at("max_displacement_m").get<double>()) + " mm"});
  std::cout << table.text();
  for (const json& file : report.at("files")) std::cout << "Written: " << file.get<std::string>() << '\n';
}

void print_motion(const json& report) {
  const auto number = [&](const char* key, const char* unit) {
    const json& value = report.at(key);
    return value.is_number() ? short_number(value.get<double>()) + unit : std::string("none");
  };
  const auto add = [&](TextTable& table, const char* text, const char* key) {
    if (report.contains(key)) table.add({text, report.at(key).dump()});
  };
  TextTable table({"measure", "value"}, "lr");
  table.add({"method", report.at("method").get<std::string>()});
  table.add({"integrator", report.at("integrator").get<std::string>()});
  table.add({"engine", report.at("engine").get<std::string>() + ", " +
                           report.at("precision").get<std::string>() + " precision"});
  table.add({"outcome", report.at("outcome").get<std::string>()});
  table.add({"vertices", report.at("vertices").dump()});
  add(table, "springs", "springs");
  add(table, "modes", "modes");
  if (report.contains("holdings")) {
    add(table, "holdings with modes of their own", "holdings");
    table.add({"set-up: elements and modes", duration_text(report.at("setup_s").get<double>())});
    table.add({"displacement left out where loads come or go", number("left_out_at_phases", "")});
  }
  table.add({"time step", number("time_step_s", " s")});
  table.add({"longest stable step at rest", number("stable_step_s", " s")});
  table.add({"steps", report.at("steps").dump()});
  table.add({"simulated time", number("simulated_s", " s")});
  table.add({"time of the steps", time_text(report.at("kernel_s").get<double>())});
  table.add({"largest displacement", number("max_displacement_m", " m")});
  table.add({"displacement at the end", number("end_displacement_m", " m")});
  table.add({"peak speed", number("peak_speed_m_s", " m/s")});
  add(table, "speeds cut to the limit", "speeds_cut");
  table.add({"inverted tetrahedra, most", report.at("inverted_tets_most").dump()});
  add(table, "springs of length zero", "zero_length_springs");
  table.add({"hash of the last state", report.at("state_hash").get<std::string>()});
  std::cout << table.text();
  const json& files = report.at("files");
  std::cout << "Written: " << files.front().get<std::string>() << " and " << files.size() - 1
            << " more in its folder\n";
}

/// What there is to say of a run beside its table, on standard error.
void print_remarks(const json& report, double timeout_s) {
  const auto outcome = report.at("outcome").get<std::string>();
  const std::string place = report.at("steps").dump() + " of " + report.at("steps_planned").dump() +
                            " steps, at " + short_number(report.at("simulated_s").get<double>()) +
                            " s of the motion; what was computed is written";
  if (outcome == "timed_out")
    print_note("stopped after " + duration_text(timeout_s) + ": " + place + "; --timeout allows more");
  if (outcome == "interrupted") print_note("interrupted: " + place);
  if (outcome == "unsolved")
    print_note("the solver did not come to its tolerance in " + report.at("steps_unsolved").dump() + " of " +
               report.at("steps").dump() + " steps; a shorter step may do");
  const json share = report.value("rounding_gain_over_kinetic", json());
  constexpr double kNoticed = 0.01;
  if (share.is_number() && share.get<double>() > kNoticed)
    print_note("single precision: rounding of positions adds about " +
               short_number(report.at("rounding_gain_j").get<double>()) + " J in these steps, " +
               short_number(100.0 * share.get<double>()) +
               "% of the greatest kinetic energy, less where there is damping; precision: double does not");
}

int exit_code_of(const json& report) {
  const auto outcome = report.at("outcome").get<std::string>();
  if (outcome == "completed") return kDone;
  if (outcome == "timed_out") return kCouldNotRun;
  return outcome == "interrupted" ? kInterrupted : kNotAccepted;
}

/// The files of a motion, as the engine has written them to the folder, and its summary.
void add_files(const fs::path& out, json& report) {
  std::vector<std::string> files{(out / "history.csv").string()};
  const auto frames = report.at("frames_written").get<std::size_t>();
  if (frames > 0) files.push_back((out / "frames.pvd").string());
  for (std::size_t k = 0; k < frames; ++k) files.push_back((out / reference::frame_name(k)).string());
  files.push_back((out / "summary.json").string());
  report["files"] = files;
  write_file_atomically(out / "summary.json", report.dump(2) + "\n");
}

/// Runs the task, and says on standard error how far it is.
ContestantAnswer run_watched(ContestantTask task, const std::string& where) {
  MotionWatch watch(task.scratch / "progress.json");
  task.while_waiting = [&watch] { watch.look(); };
  ContestantAnswer answer = run_moving_task(task, where);
  watch.look();  // of a short one, all that there is to say
  return answer;
}

/// Why a part that the scene's model holds at rest has to wake, or an empty string.
std::string why_to_wake(const Scene& scene, const ContestantAnswer& answer) {
  if (!scene.model || answer.outcome != "ok") return "";
  const auto frozen = scene.model->set.find("frozen");
  return frozen == scene.model->set.end() ? "" : why_it_wakes(frozen->second.text, answer.report);
}

int simulate_dynamic(const Scene& scene, const SimulateArguments& arguments) {
  constexpr double kGraceSeconds = 600.0;  // to write what there is
  const Stopwatch clock;
  const volatile std::sig_atomic_t* stop_flag = catch_stop_signals();
  const ResultFolder folder(arguments.out);
  const Registry registry = load_registry();
  const MadeMesh made = build_scene_mesh(scene.mesh);
  for (const std::string& note : made.notes) print_note(note);
  for (const std::string& useless : check_moving_scene(place_scene(scene, made.mesh), made.mesh))
    print_note(useless);
  const ScratchFolder scratch;
  const auto run = [&](const Scene& which, const char* name) {
    const reference::MovingBody body = build_moving_body(place_scene(which, made.mesh), made.mesh, registry);
    ContestantTask task = start_replay(body, made.mesh, registry, scratch.file(name));
    task.folder_out = fs::absolute(arguments.out);
    task.threads = arguments.threads;
    task.stop_flag = stop_flag;
    task.stop_grace_s = kGraceSeconds;
    task.options["stop_after_s"] = std::max(1e-6, arguments.timeout_s - clock.seconds());
    task.options["max_output_gb"] = arguments.most_output_gb;
    return run_watched(std::move(task), which.analysis_where);
  };
  ContestantAnswer answer = run(scene, "body");
  if (const std::string why = why_to_wake(scene, answer); !why.empty()) {
    print_note(why + ": it wakes, and the whole model is stepped from the start");
    Scene whole = scene;
    whole.model->set.erase("frozen");
    answer = run(whole, "whole");
  }
  if (answer.outcome == "interrupted") {
    print_note("interrupted before there was anything to write");
    return kInterrupted;
  }
  for (const std::string& note : answer.notes) print_note(note);
  json report = answer.report;
  report["schema"] = "palpate/motion/1";
  report["preset"] = scene.dynamic.preset.empty() ? json(nullptr) : json(scene.dynamic.preset);
  add_files(arguments.out, report);
  if (arguments.as_json) {
    print_json(report);
  } else {
    print_motion(report);
  }
  print_remarks(report, arguments.timeout_s);
  return exit_code_of(report);
}

int simulate(const SimulateArguments& arguments) {
  const Scene scene = read_scene(arguments.scene);
  require_replaceable_results(scene, arguments.out);
  for (const std::string& line : leaves_envelope(scene)) print_note("outside of what was fitted: " + line);
  if (scene.is_dynamic) return simulate_dynamic(scene, arguments);
  const Registry registry = load_registry();
  ContestantTask task;
  task.method = find_model(scene, registry);
  task.options = resolve_options(*task.method.method, scene.model->set);
  const std::string why = task.method.contestant->unavailable();
  if (!why.empty()) throw UnavailableError(scene.model->method + " is unavailable: " + why);
  const ResultFolder folder(arguments.out);
  const MadeMesh made = build_scene_mesh(scene.mesh);
  for (const std::string& note : made.notes) print_note(note);
  const BoundaryProblem problem = build_problem(place_scene(scene, made.mesh), made.mesh);
  const ScratchFolder scratch;
  task.mesh_in = scratch.file("in.mesh");
  task.problem_in = scratch.file("problem.json");
  task.scratch = scratch.file("run");
  fs::create_directories(task.scratch);
  write_medit(task.mesh_in, made.mesh);
  write_file_atomically(task.problem_in, reference::problem_to_json(problem).dump() + "\n");
  task.threads = arguments.threads;
  task.timeout_s = arguments.timeout_s;
  ContestantAnswer answer = run_contestant(task);
  if (const std::string woken = why_to_wake(scene, answer); !woken.empty()) {
    print_note(woken + ": it wakes, and the whole model is solved");
    task.options.erase("frozen");
    answer = run_contestant(task);
  }
  if (answer.outcome == "bad_input") throw InputError(scene.model->method + ": " + answer.message);
  if (answer.outcome != "ok")
    throw UnavailableError(scene.model->method + ": " + answer.outcome + ": " + answer.message);
  for (const std::string& note : answer.notes) print_note(note);
  const json report = write_result(answer, scene.model->method, made.mesh, arguments.out);
  if (arguments.as_json) {
    print_json(report);
  } else {
    print_result(report);
  }
  if (report.at("outcome") == "buckled")
    print_note(
        "buckled: the body can give way in some direction without resistance. A vertex that hangs on too few "
        "springs is the usual cause, and palpate springs names them; docs/scenes.md says what to do");
  return report.at("outcome") == "converged" ? kDone : kNotAccepted;
}

}  // namespace

void add_simulate_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<SimulateArguments>();
  CLI::App* command = app.add_subcommand("simulate", "Solve one scene with the model that it names");
  command->add_option("SCENE", arguments->scene, "Scene file (.yaml)")->required();
  command->add_option("-o,--output", arguments->out, "Folder for what it writes")
      ->required()
      ->type_name("DIR");
  command
      ->add_option("--timeout", arguments->timeout_s,
                   "Seconds before the method is stopped; of a motion, between two steps (3600)")
      ->check(number_from(0.01, 1e7))
      ->type_name("S");
  command->add_option("--threads", arguments->threads, "Threads that the method may use (1)")
      ->transform(whole_number_from(1, 1024))
      ->type_name("N");
  command
      ->add_option("--max-output-gb", arguments->most_output_gb,
                   "A dynamic scene that may write more is refused (2)")
      ->check(number_from(0.0, 1e9))
      ->type_name("GB");
  command->footer(
      "A static scene leaves displacement.csv and displacement.vtu; the exit code is 1, without files, if "
      "the method "
      "found no equilibrium. A dynamic one leaves frames.pvd with its frames, history.csv and summary.json; "
      "the exit "
      "code is 1 if it diverged, ends with inverted tetrahedra or has steps without a solution, 3 after the "
      "time-out and 130 after Ctrl-C: what was computed until then is written. Results of an earlier run in "
      "DIR are removed; where a file of their names is none of them, nothing is done.");
  command->add_flag("--json", arguments->as_json, "Print the report as JSON");
  command->callback([arguments, &exit_code] { exit_code = simulate(*arguments); });
}

}  // namespace palpate::experiments

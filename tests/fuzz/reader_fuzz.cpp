// libFuzzer target for the readers of files and answers: any bytes are read, or refused by one InputError.
// PALPATE_FUZZ_READER names the reader (tests/fuzz/fuzz.py runs them all).
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>

#include "core/base/error.h"
#include "core/mesh/io/medit.h"
#include "core/mesh/io/off.h"
#include "core/mesh/orientation.h"
#include "core/mesh/shapes/shapes.h"
#include "core/simplify/sizing/size_file.h"
#include "core/springs/network/moduli_csv.h"
#include "core/springs/network/springs_csv.h"
#include "experiments/contestants/answer_form.h"
#include "experiments/contests/engine/engine_judge.h"
#include "experiments/contests/stability/stability_answer.h"
#include "experiments/fit/candidates/fit_candidates.h"
#include "experiments/gates/accepted_figures.h"
#include "experiments/records/provenance.h"
#include "experiments/records/record_file.h"
#include "experiments/registry/description.h"
#include "experiments/registry/registry.h"
#include "experiments/runner/read_plan.h"
#include "experiments/scene_reader/scene.h"
#include "experiments/spring_training/training_plan.h"
#include "reference/door/deform_problem.h"
#include "reference/door/json_file.h"
#include "reference/door/motion_problem.h"
#include "reference/door/moving_body.h"
#include "reference/door/stability_problem.h"
#include "reference/reduced/pod_file.h"
#ifdef PALPATE_FUZZ_SURFACES
#include "reference/cgal/surface_tools.h"
#endif

namespace {

namespace fs = std::filesystem;
using namespace palpate;
using namespace palpate::experiments;

void check(bool condition) {
  if (!condition) std::abort();
}

/// The mesh that what belongs to one is read for.
const TetMesh& small_mesh() {
  static const TetMesh mesh = build_kuhn_cube(1, 0.0, 0);
  return mesh;
}

const Registry& registry() {
  static const Registry all = load_registry();
  return all;
}

/// A mesh that was read comes back to the bit.
void read_and_write(const fs::path& file) {
  const TetMesh mesh = read_medit(file).mesh;
  const auto& p = mesh.points;
  check(!mesh.tets.empty());
  check(std::all_of(p.begin(), p.end(), is_finite));
  for (const Tet& t : mesh.tets) {
    for (const Index v : t) check(v < p.size());
    check(orientation(p[t[0]], p[t[1]], p[t[2]], p[t[3]]) == 1);
  }
  write_medit(file, mesh);
  check(read_medit(file).mesh == mesh);
}

/// A trained body that was read comes back to the bit, and can be asked.
void read_and_ask(const fs::path& file) {
  const reference::TrainedPod trained = reference::read_pod(file);
  reference::write_pod(file, trained);
  const std::string first = reference::read_text_file(file, std::size_t{1} << 24U);
  reference::write_pod(file, reference::read_pod(file));
  check(reference::read_text_file(file, std::size_t{1} << 24U) == first);
  const dynamics::PodBody body(trained.parts);
  body.gradient(Eigen::VectorXd::Zero(body.basis().shapes.cols()));
}

/// A request whose problem is the file.
reference::Request request_of(const char* contest, const fs::path& file) {
  static const fs::path mesh = file.parent_path() / "in.mesh";
  if (!fs::exists(mesh)) write_medit(mesh, small_mesh());
  reference::Request request;
  request.contest = contest;
  request.input = mesh;
  request.problem = file;
  return request;
}

/// What the judge finds in an answer of the engine on the small mesh.
void judge_engine(const fs::path& file) {
  reference::MotionProblem problem;
  problem.duration_s = 1.0;
  nlohmann::json figures = judge_engine_file(problem, small_mesh(), {{"outcome", "completed"}}, file);
  compare_force({{1.0, 0.0, 0.0}, 0.01}, figures);
}

/// A part's provenance is held against that of the run that takes it.
void read_and_compare(const fs::path& file) {
  const nlohmann::json theirs = read_provenance(file);
  const nlohmann::json ours = {{"plan_hash", "xxh3:0"}, {"files", {{"a", "b"}}}, {"programs", {{"a", "b"}}}};
  find_changes(theirs, ours);
  find_changes(ours, theirs);
}

struct Reader {
  const char* name;
  const char* file;  ///< what the file is called
  void (*read)(const fs::path& file);
};

constexpr std::array kReaders{
    Reader{"medit", "any.mesh", read_and_write},
    Reader{"off", "any.off", [](const fs::path& f) { read_off(f); }},
    Reader{"springs_csv", "any.csv", [](const fs::path& f) { springs::read_springs_csv(f, small_mesh()); }},
    Reader{"moduli_csv", "any.csv", [](const fs::path& f) { springs::read_moduli_csv(f, small_mesh()); }},
    Reader{"displacement_csv", "any.csv",
           [](const fs::path& f) { reference::read_displacement(f, small_mesh().points.size(), 19); }},
    Reader{"history_csv", "any.csv", [](const fs::path& f) { reference::read_history(f, {}); }},
    Reader{"plan", "any.yaml", [](const fs::path& f) { read_plan(f, registry()); }},
    Reader{"scene", "any.yaml", [](const fs::path& f) { read_scene(f); }},
    Reader{"training", "any.yaml", [](const fs::path& f) { read_training_plan(f); }},
    Reader{"candidates", "any.yaml", [](const fs::path& f) { read_candidates(f, registry()); }},
    Reader{"contestant", "contestant.yaml", [](const fs::path& f) { read_description(f, f.parent_path()); }},
    Reader{"response", "any.json",
           [](const fs::path& f) { parse_answer(reference::read_text_file(f, kLargestAnswer)); }},
    Reader{"records", "any.jsonl", [](const fs::path& f) { read_records(f); }},
    Reader{"provenance", "any.json", read_and_compare},
    Reader{"accepted", "any.json", [](const fs::path& f) { read_accepted(f, "ci"); }},
    Reader{"deform_problem", "any.json",
           [](const fs::path& f) { reference::read_deform_task(request_of("deform", f)); }},
    Reader{"motion_problem", "any.json",
           [](const fs::path& f) { reference::read_motion_task(request_of("motion", f)); }},
    Reader{"moving_body", "any.json",
           [](const fs::path& f) { reference::read_moving_task(request_of("engine", f)); }},
    Reader{"stability_problem", "any.json",
           [](const fs::path& f) { reference::read_stability_task(request_of("stability", f)); }},
    Reader{"pod_body", "any.pod", read_and_ask},
    Reader{"engine_answer", "any.json", judge_engine},
    Reader{"sizes_csv", "any.csv",
           [](const fs::path& f) { simplify::read_sizes(f, small_mesh().points.size()); }},
    Reader{"stability_answer", "any.json", [](const fs::path& f) { read_stability_answer(f, small_mesh()); }},
#ifdef PALPATE_FUZZ_SURFACES
    Reader{"stl", "any.stl", [](const fs::path& f) { reference::read_surface(f); }},
    Reader{"off_surface", "any.off", [](const fs::path& f) { reference::read_surface(f); }},
    Reader{"obj", "any.obj", [](const fs::path& f) { reference::read_surface(f); }},
    Reader{"ply", "any.ply", [](const fs::path& f) { reference::read_surface(f); }},
#endif
};

const Reader& wanted_reader() {
  const char* name = std::getenv("PALPATE_FUZZ_READER");
  for (const Reader& reader : kReaders) {
    if (name != nullptr && name == std::string(reader.name)) return reader;
  }
  for (const Reader& reader : kReaders) std::cout << reader.name << '\n';
  std::cout.flush();  // libFuzzer ends the process before the streams are
  std::exit(2);
}

fs::path scratch_folder() {
  std::string name = (fs::temp_directory_path() / "palpate-fuzz-XXXXXX").string();
  check(::mkdtemp(name.data()) != nullptr);
  return name;
}

}  // namespace

// NOLINTNEXTLINE(readability-identifier-naming): the name that libFuzzer calls
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Reader& reader = wanted_reader();
  static const fs::path file = scratch_folder() / reader.file;
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  try {
    reader.read(file);
  } catch (const InputError&) {
    return 0;
  }
  return 0;
}

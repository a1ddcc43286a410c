// Adapter of fem.p1 and fem.p2: linear and neo-Hookean elasticity by FEniCSx (dolfinx). It answers for
// moving_fem.p1 and moving_fem.p2 too.
#include <slepcsys.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/mesh/subdivision/refinement.h"
#include "core/mesh/topology.h"
#include "reference/door/deform_problem.h"
#include "reference/door/json_file.h"
#include "reference/door/request_options.h"
#include "reference/fenicsx/motion/motion_answer.h"
#include "reference/fenicsx/statics/equilibrium.h"
#include "reference/fenicsx/statics/mpi_processes.h"
#include "reference/fenicsx/statics/rigid_motions.h"

namespace palpate::reference::fenicsx {
namespace {

using nlohmann::json;

constexpr std::int64_t kMostRefinements = 3;
constexpr std::size_t kTimedAnswers = 9;

/// The displacement of the base mesh's vertices and edge midpoints, on process 0; empty elsewhere.
std::vector<Vec3> gather_rows(const TetMesh& base, const ElasticBody& body, const Vector& displacement) {
  const std::vector<Edge> edges = build_edges(base);
  const std::size_t vertices = base.points.size();
  std::vector<double> here;  // row, x, y, z
  const LocalEntries entries(displacement.get());
  for (std::size_t node = 0; node < body.owned_nodes(); ++node) {
    const Edge& ends = body.nodes()[node];
    std::size_t row = ends[0];
    if (ends[0] != ends[1]) {  // on a refined mesh, no edge of the base mesh
      const auto at = std::lower_bound(edges.begin(), edges.end(), ends);
      if (at == edges.end() || *at != ends) continue;
      row = vertices + static_cast<std::size_t>(at - edges.begin());
    }
    if (row >= vertices + edges.size()) continue;
    here.insert(here.end(),
                {static_cast<double>(row), entries[3 * node], entries[3 * node + 1], entries[3 * node + 2]});
  }
  const int rank = process_rank();
  const int size = process_count();
  const int count = static_cast<int>(here.size());
  std::vector<int> counts(static_cast<std::size_t>(size));
  MPI_Gather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, PETSC_COMM_WORLD);
  std::vector<int> offsets(static_cast<std::size_t>(size) + 1, 0);
  for (std::size_t p = 0; p < counts.size(); ++p) offsets[p + 1] = offsets[p] + counts[p];
  std::vector<double> all(rank == 0 ? static_cast<std::size_t>(offsets.back()) : 0);
  MPI_Gatherv(here.data(), count, MPI_DOUBLE, all.data(), counts.data(), offsets.data(), MPI_DOUBLE, 0,
              PETSC_COMM_WORLD);
  if (rank != 0) return {};
  std::vector<Vec3> rows(vertices + edges.size());
  std::vector<bool> known(rows.size(), false);
  for (std::size_t i = 0; i < all.size(); i += 4) {
    const auto row = static_cast<std::size_t>(all[i]);
    rows[row] = {all[i + 1], all[i + 2], all[i + 3]};
    known[row] = true;
  }
  for (std::size_t e = 0; e < edges.size(); ++e) {  // linear shapes have no node there
    if (!known[vertices + e]) rows[vertices + e] = 0.5 * (rows[edges[e][0]] + rows[edges[e][1]]);
  }
  return rows;
}

/// What a request asks.
struct Options {
  EquilibriumOptions equilibrium;
  std::int64_t refine = 0;
  std::string further;  ///< a file that lists more loads of the same body; empty: none
  bool with_cost = false;
};

Options read_options(const Request& request) {
  if (request.method != "fem.p1" && request.method != "fem.p2")
    throw InputError("method", 0, "fem.p1 or fem.p2", request.method);
  json left = request.options;
  Options options;
  if (left.contains("solver")) {
    options.equilibrium.solver =
        static_cast<SolverChoice>(take_choice(left, "solver", {"auto", "mumps", "gamg"}));
  }
  options.equilibrium.tolerance_relative =
      take_number(left, "rtol", 1e-14, 0.1, options.equilibrium.tolerance_relative);
  options.refine = take_whole(left, "refine", 0, kMostRefinements, 0);
  options.further =
      take_option<std::string>(left, "further", &json::is_string, "the path of a list of problems", "");
  options.with_cost = take_option<bool>(left, "cost", &json::is_boolean, "true or false", false);
  take_whole(left, "processes", 1, kMostProcesses, 1);  // start_mpirun() has seen to it
  require_all_taken(left);
  return options;
}

/// One load of the body, and where its displacement goes.
struct Load {
  BoundaryProblem problem;
  std::filesystem::path output;
};

/// The request's own load and those of the file `further`: [{"problem_in": ..., "displacement_out": ...}].
std::vector<Load> read_loads(const Request& request, const std::string& further, const DeformTask& task) {
  std::vector<Load> loads{{task.problem, request.output}};
  if (further.empty()) return loads;
  const json list = read_json_file(further);
  if (!list.is_array()) throw InputError(further, 0, "a list of problems", "something else");
  for (const json& item : list) {
    const auto path = [&](const char* key) {
      const json value = item.is_object() ? item.value(key, json()) : json();
      if (!value.is_string())
        throw InputError(further, 0, std::string("the path \"") + key + "\"", value.dump());
      return value.get<std::string>();
    };
    const std::string file = path("problem_in");
    Load load{problem_from_json(read_json_file(file), task.mesh, file), path("displacement_out")};
    if (!share_stiffness(task.problem, load.problem))
      throw InputError(file, 0, "the same body on the same supports, at small strain", "another stiffness");
    loads.push_back(std::move(load));
  }
  return loads;
}

json describe(const Request& request, const Options& options, const ElasticBody& body,
              const Equilibrium& found) {
  json report = {{"method", request.method},
                 {"outcome", found.outcome},
                 {"refine", options.refine},
                 {"dofs", 3 * body.global_nodes()},
                 {"processes", process_count()},
                 {"solver", found.solver},
                 {"iterations", found.linear_iterations},
                 {"newton_steps", found.newton_steps},
                 {"load_steps", found.load_steps},
                 {"residual_relative", found.residual_relative},
                 {"energy_j", found.strain_energy_j},
                 {"support_energy_j", found.support_energy_j},
                 {"support_forces_n", json::array()},
                 {"assembly_s", found.assembly_s},
                 {"solve_s", found.solve_s}};
  for (const Vec3& force : found.support_forces_n)
    report["support_forces_n"].push_back({force.x, force.y, force.z});
  return report;
}

/// The median time of a displacement from a new load with the factors that are there. The body's own load
/// stands for a new one: no solve starts from what another found.
double measure_answer_s(const TetMesh& mesh, const BoundaryProblem& problem, ElasticBody& body,
                        const EquilibriumOptions& options) {
  const std::vector<BoundaryProblem> repeated(1 + kTimedAnswers, problem);
  std::vector<double> times;
  for (const Equilibrium& found : find_equilibria(mesh, repeated, body, options))
    times.push_back(found.solve_s);
  times.erase(times.begin());  // it factored
  std::nth_element(times.begin(), times.begin() + kTimedAnswers / 2, times.end());
  return times[kTimedAnswers / 2];
}

Response answer(const Request& request) {
  if (request.contest == "motion") return answer_motion(request);
  const Options options = read_options(request);
  const DeformTask task = read_deform_task(request);
  require_no_free_motion(task.mesh, task.problem);
  if (options.with_cost && !share_stiffness(task.problem, task.problem))
    throw InputError("cost", 0, "small strain, and nothing held that moves: one linear system",
                     "another problem");
  const std::vector<Load> loads = read_loads(request, options.further, task);
  TetMesh mesh = task.mesh;
  std::vector<BoundaryProblem> problems;
  problems.reserve(loads.size());
  for (const Load& load : loads) problems.push_back(load.problem);
  for (std::int64_t level = 0; level < options.refine; ++level) {
    TetMesh refined = refine_uniformly(mesh);
    for (BoundaryProblem& problem : problems) problem = refine_problem(problem, mesh, refined);
    mesh = std::move(refined);
  }
  Response response;
  std::vector<std::vector<Vec3>> rows(loads.size());
  together([&] {
    const Stopwatch watch;
    ElasticBody body(mesh, problems.front().material, problems.front().strain,
                     request.method == "fem.p1" ? 1 : 2);
    const double setup_s = watch.seconds();
    std::vector<Equilibrium> found = find_equilibria(mesh, problems, body, options.equilibrium);
    response.kernel_s = watch.seconds();
    found.front().assembly_s += setup_s;
    response.report = describe(request, options, body, found.front());
    if (options.with_cost)
      response.report["answer_s"] = measure_answer_s(mesh, problems.front(), body, options.equilibrium);
    for (std::size_t k = 0; k < found.size(); ++k) {
      if (k > 0) {
        json report = describe(request, options, body, found[k]);
        report["factors_of_another_load"] = true;
        response.report["further"].push_back(std::move(report));
      }
      if (found[k].outcome == "converged") rows[k] = gather_rows(task.mesh, body, found[k].displacement);
    }
  });
  for (std::size_t k = 0; k < loads.size(); ++k) {
    if (!rows[k].empty()) write_displacement(loads[k].output, rows[k]);
  }
  return response;
}

bool is_under_mpirun() {
  return std::getenv("OMPI_COMM_WORLD_SIZE") != nullptr;
}

/// Settings of Open MPI for processes on this machine alone, unless the user's environment has others: no
/// search for networks, no daemon beside a single process, no ssh; memory is shared as containers allow.
void prepare_mpi() {
  if (is_under_mpirun()) return;
  setenv("OMPI_MCA_pml", "ob1", 0);
  setenv("OMPI_MCA_btl", "self,vader", 0);
  setenv("OMPI_MCA_btl_vader_single_copy_mechanism", "none", 0);
  setenv("OMPI_MCA_ess_singleton_isolated", "1", 0);
  setenv("OMPI_MCA_plm_rsh_agent", "", 0);
  setenv("OMPI_MCA_mpi_yield_when_idle", "1", 0);
}

/// A folder for Open MPI's own files beside the response. In the one that it takes by itself, all single
/// processes of a user share a folder that each removes at its end, and one that starts at that moment fails.
class MpiFolder {
 public:
  MpiFolder(int argc, char** argv) {
    if (argc != 3 || is_under_mpirun()) return;
    std::error_code failed;
    const std::filesystem::path wanted = std::filesystem::absolute(std::string(argv[2]) + ".mpi", failed);
    if (failed || !std::filesystem::create_directory(wanted, failed)) return;  // then it takes its own
    folder_ = wanted;
    setenv("OMPI_MCA_orte_tmpdir_base", folder_.c_str(), 0);
  }
  ~MpiFolder() {
    std::error_code ignored;
    if (!folder_.empty()) std::filesystem::remove_all(folder_, ignored);
  }
  MpiFolder(const MpiFolder&) = delete;
  MpiFolder& operator=(const MpiFolder&) = delete;

 private:
  std::filesystem::path folder_;
};

/// Becomes mpirun of itself if the request asks for more than one process. Returns if it does not, if it runs
/// under mpirun already, and if the request cannot be read, which run_adapter then tells. Throws:
/// UnavailableError without mpirun.
void start_mpirun(int argc, char** argv) {
  if (argc != 3 || is_under_mpirun()) return;
  json request;
  try {
    request = read_json_file(argv[1]);
  } catch (const InputError&) {
    return;
  }
  if (!request.is_object()) return;
  const json options = request.value("options", json::object());
  if (!options.is_object() || !options.contains("processes") || !options["processes"].is_number_integer())
    return;
  const auto count = options["processes"].get<std::int64_t>();
  if (count < 2 || count > kMostProcesses) return;
  if (geteuid() == 0) {  // in a container; Open MPI wants to hear it twice
    setenv("OMPI_ALLOW_RUN_AS_ROOT", "1", 0);
    setenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1", 0);
  }
  const std::string number = std::to_string(count);
  const std::string self = std::filesystem::read_symlink("/proc/self/exe").string();
  execlp("mpirun", "mpirun", "-quiet", "--oversubscribe", "--bind-to", "none", "-np", number.c_str(),
         self.c_str(), argv[1], argv[2], static_cast<char*>(nullptr));
  throw UnavailableError("more than one process needs mpirun (Debian: openmpi-bin)");
}

/// Answers on process 0; the others work along, and what they have to say is said by process 0 already.
int run_on_all(int argc, char** argv) {
  const int rank = process_rank();
  if (rank == 0 || argc != 3) return run_adapter(argc, argv, answer);
  std::string aside = std::string(argv[2]) + ".process" + std::to_string(rank);
  std::array<char*, 3> arguments{argv[0], argv[1], aside.data()};
  if (std::freopen("/dev/null", "w", stderr) == nullptr) return 3;
  run_adapter(argc, arguments.data(), answer);
  std::error_code ignored;
  std::filesystem::remove(aside, ignored);
  return 0;
}

int run(int argc, char** argv) {
  const auto refuse = [&](const std::exception& error) {
    const std::string message = error.what();
    return run_adapter(argc, argv, [&](const Request&) -> Response { throw UnavailableError(message); });
  };
  prepare_mpi();
  try {
    start_mpirun(argc, argv);
  } catch (const std::exception& error) {
    return refuse(error);
  }
  const MpiFolder own_folder(argc, argv);
  try {
    check(SlepcInitialize(nullptr, nullptr, nullptr, nullptr), "SlepcInitialize");
  } catch (const std::exception& error) {
    return refuse(error);
  }
  PetscPopSignalHandler();                                  // a crash is a crash
  PetscPushErrorHandler(PetscIgnoreErrorHandler, nullptr);  // check() tells
  const int code = run_on_all(argc, argv);
  SlepcFinalize();
  return code;
}

}  // namespace
}  // namespace palpate::reference::fenicsx

int main(int argc, char** argv) {
  return palpate::reference::fenicsx::run(argc, argv);
}

// Adapter of fem.p1 and fem.p2: linear and neo-Hookean elasticity by FEniCSx (dolfinx).
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>

#include "core/base/error.h"
#include "core/mesh/refinement.h"
#include "core/mesh/topology.h"
#include "reference/deform_problem.h"
#include "reference/fenicsx/equilibrium.h"
#include "reference/fenicsx/rigid_motions.h"
#include "reference/fusion_options.h"

namespace palpate::reference::fenicsx {
namespace {

using nlohmann::json;

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
  int rank = 0;
  int size = 1;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  MPI_Comm_size(PETSC_COMM_WORLD, &size);
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

Response answer(const Request& request) {
  if (request.method != "fem.p1" && request.method != "fem.p2")
    throw InputError("method", 0, "fem.p1 or fem.p2", request.method);
  json left = request.options;
  EquilibriumOptions options;
  if (left.contains("solver")) {
    options.solver = static_cast<SolverChoice>(take_choice(left, "solver", {"auto", "mumps", "gamg"}));
  }
  options.tolerance_relative = take_number(left, "rtol", 1e-14, 0.1, options.tolerance_relative);
  const auto refine = take_whole(left, "refine", 0, 3, 0);
  require_all_taken(left);
  const DeformTask task = read_deform_task(request);
  require_no_free_motion(task.mesh, task.problem);

  TetMesh mesh = task.mesh;
  BoundaryProblem problem = task.problem;
  for (std::int64_t level = 0; level < refine; ++level) {
    TetMesh refined = refine_uniformly(mesh);
    problem = refine_problem(problem, mesh, refined);
    mesh = std::move(refined);
  }
  const auto start = std::chrono::steady_clock::now();
  ElasticBody body(mesh, problem.material, problem.strain, request.method == "fem.p1" ? 1 : 2);
  const double setup_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const Equilibrium found = find_equilibrium(mesh, problem, body, options);
  Response response;
  response.kernel_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  response.report = {{"method", request.method},
                     {"outcome", found.outcome},
                     {"dofs", 3 * body.global_nodes()},
                     {"refine", refine},
                     {"solver", found.solver},
                     {"iterations", found.linear_iterations},
                     {"residual_relative", found.residual_relative},
                     {"energy_j", found.strain_energy_j},
                     {"support_energy_j", found.support_energy_j},
                     {"assembly_s", setup_s + found.assembly_s},
                     {"solve_s", found.solve_s}};
  const std::vector<Vec3> rows = gather_rows(task.mesh, body, found.displacement);
  if (!rows.empty() && found.outcome == "converged") write_displacement(request.output, rows);
  return response;
}

/// Quiets what Open MPI says about containers, where processes may not read each other's memory.
void set_mpi_defaults() {
  setenv("OMPI_MCA_btl_vader_single_copy_mechanism", "none", 0);
  setenv("OMPI_MCA_plm_rsh_agent", "", 0);
}

int run(int argc, char** argv) {
  set_mpi_defaults();
  check(PetscInitialize(nullptr, nullptr, nullptr, nullptr), "PetscInitialize");
  PetscPopSignalHandler();
  PetscPushErrorHandler(PetscIgnoreErrorHandler, nullptr);  // check() tells
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  const int code = run_adapter(argc, argv, answer);
  PetscFinalize();
  return code;
}

}  // namespace
}  // namespace palpate::reference::fenicsx

int main(int argc, char** argv) {
  return palpate::reference::fenicsx::run(argc, argv);
}

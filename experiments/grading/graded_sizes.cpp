#include "experiments/grading/graded_sizes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/topology.h"
#include "core/simplify/sizing/error_sizes.h"
#include "core/simplify/sizing/kept_region_text.h"
#include "core/simplify/sizing/sizing.h"
#include "core/simplify/sizing/triangle_tree.h"
#include "experiments/contestants/answer_cache.h"
#include "experiments/contestants/solution.h"
#include "experiments/files/output_file.h"
#include "experiments/files/problem_folder.h"
#include "experiments/files/scratch_folder.h"
#include "reference/door/deform_problem.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

constexpr double kPilotTimeout = 1800.0;  // s

bool is_pushed(const ElasticSupport& support) {
  return length_sq(support.by_m) > 0.0;
}

/// The faces that a word means; a vertex with a force is a face without area.
std::vector<Triangle> faces_of_word(const std::string& word, const BoundaryProblem& problem) {
  std::vector<Triangle> faces;
  const auto add = [&](const std::vector<Triangle>& more) {
    faces.insert(faces.end(), more.begin(), more.end());
  };
  const bool pads = word == "pads" || word == "loads";
  if (pads || word == "supports") {
    for (const HeldFaces& held : problem.held) {
      if ((length_sq(held.by_m) > 0.0) == pads) add(held.faces);
    }
    for (const ElasticSupport& support : problem.supports) {
      if (is_pushed(support) == pads) add(support.patch.faces);
    }
  }
  if (word == "forces" || word == "loads") {
    for (const Traction& traction : problem.tractions) add(traction.patch.faces);
    for (const NodalForce& force : problem.nodal_forces)
      faces.push_back({force.vertex, force.vertex, force.vertex});
  }
  return faces;
}

/// Lowers `nearest` to the distance from each vertex to the faces.
void add_faces(const TetMesh& mesh, const std::vector<Triangle>& faces, std::vector<double>& nearest) {
  const simplify::TriangleTree tree(mesh.points, faces);
  for (std::size_t v = 0; v < nearest.size(); ++v)
    nearest[v] = std::min(nearest[v], tree.distance(mesh.points[v], nearest[v]));
}

void add_region(const TetMesh& mesh, const std::string& text, std::vector<double>& nearest) {
  simplify::SizingOptions options;
  options.keep.push_back(simplify::parse_kept_region(text, "near"));
  const simplify::SizingField field(options, mesh);
  const std::vector<std::uint8_t> met = simplify::build_kept_tets(field, mesh);
  if (std::none_of(met.begin(), met.end(), [](std::uint8_t flag) { return flag != 0; }))
    throw InputError("near", 0, "a region in metres that meets the body",
                     "\"" + text + "\", which meets no tetrahedron");
  for (std::size_t v = 0; v < nearest.size(); ++v)
    nearest[v] = std::min(nearest[v], field.distance(mesh.points[v]));
}

void add_place(const GradedBody& body, const std::string& text, std::vector<double>& nearest) {
  if (text.find(' ') != std::string::npos) {
    add_region(body.mesh, text, nearest);
    return;
  }
  if (text == "probes" && !body.probes_m.empty()) {
    for (const Vec3& probe : body.probes_m) {
      for (std::size_t v = 0; v < nearest.size(); ++v)
        nearest[v] = std::min(nearest[v], length(body.mesh.points[v] - probe));
    }
    return;
  }
  const std::vector<Triangle> faces = faces_of_word(text, body.problem);
  if (faces.empty()) throw InputError("near", 0, "a scene with " + text, "none in this one");
  add_faces(body.mesh, faces, nearest);
}

/// The sizes of what is given. `touched` counts the vertices at the near size.
std::vector<double> given_sizes(const GradeWish& wish, const GradedBody& body, std::size_t& touched) {
  const BoundingBox box = bounding_box(body.mesh.points);
  const double diagonal = length(box.high - box.low);
  const double reach = wish.reach_m.value_or(0.25 * diagonal);
  std::vector<double> nearest(body.mesh.points.size(), std::numeric_limits<double>::max());
  for (const std::string& text : wish.near) add_place(body, text, nearest);
  std::vector<double> sizes(nearest.size());
  for (std::size_t v = 0; v < sizes.size(); ++v) {
    const double t = std::min(1.0, std::max(0.0, nearest[v] - wish.radius_m) / reach);
    sizes[v] = wish.near_size + (1.0 - wish.near_size) * t * t * (3.0 - 2.0 * t);
    if (t == 0.0) ++touched;
  }
  return sizes;
}

/// The pilot's displacement at the vertices; empty with a failure.
std::vector<Vec3> solve_pilot(const GradeWish& wish, const GradedBody& body, const PilotSetting& setting,
                              GradedSizes& result) {
  BoundaryProblem problem = body.problem;
  problem.strain = StrainSize::kSmall;
  const ProblemPaths files =
      write_problem_folder(body.mesh, reference::problem_to_json(problem), setting.folder);
  const ScratchFolder scratch;
  ContestantTask task;
  task.method = find_pilot(wish.pilot, setting.registry, "pilot");
  task.mesh_in = files.mesh;
  task.problem_in = files.problem;
  task.scratch = scratch.path();
  task.options = resolve_options(*task.method.method, wish.pilot_set);
  task.threads = setting.threads;
  task.timeout_s = kPilotTimeout;
  task.stop_flag = setting.stop_flag;
  const Solution solution = solve(task, "converged");
  const std::string which = "the pilot solve by " + wish.pilot + " ";
  if (solution.interrupted || !solution.failure.empty()) {
    result.failure = which + (solution.interrupted ? "was interrupted" : solution.failure);
    return {};
  }
  if (solution.answer.kernel_s) result.facts["pilot_s"] = *solution.answer.kernel_s;
  try {
    std::vector<Vec3> field = reference::read_displacement(solution.answer.output, body.mesh.points.size(),
                                                           build_edges(body.mesh).size());
    field.resize(body.mesh.points.size());
    return field;
  } catch (const InputError& error) {
    result.failure = which + "cannot be read: " + error.what();
    return {};
  }
}

}  // namespace

GradedSizes find_graded_sizes(const GradeWish& wish, const GradedBody& body, std::uint64_t tets,
                              const PilotSetting& setting) {
  GradedSizes result;
  result.facts = {{"near", wish.near}, {"pilot", wish.pilot}};
  result.sizes.assign(body.mesh.points.size(), 1.0);
  if (!wish.near.empty()) {
    std::size_t touched = 0;
    result.sizes = given_sizes(wish, body, touched);
    result.facts["touched_vertices"] = touched;
  }
  if (!wish.pilot.empty()) {
    const std::vector<Vec3> displacement = solve_pilot(wish, body, setting, result);
    if (!result.failure.empty()) return result;
    const Material& material = body.problem.material;
    const std::vector<double> errors =
        simplify::estimate_tet_errors(body.mesh, material.lambda_pa(), material.mu_pa(), displacement);
    std::vector<double> even(body.mesh.points.size(), 1.0);
    const double edge = simplify::fit_sizes(body.mesh, tets, even);  // of a mesh of one size
    const std::vector<double> by_error = simplify::sizes_of_errors(body.mesh, errors, wish.least_size, edge);
    for (std::size_t v = 0; v < by_error.size(); ++v)
      result.sizes[v] = std::min(result.sizes[v], by_error[v]);
  }
  std::vector<double> first = result.sizes;
  const double far = simplify::fit_sizes(body.mesh, tets, first);
  simplify::limit_growth(body.mesh, wish.growth, far, result.sizes);
  const double least = *std::min_element(result.sizes.begin(), result.sizes.end());
  result.far_m = simplify::fit_sizes(body.mesh, tets, result.sizes);
  result.facts["far_m"] = result.far_m;
  result.facts["least_wanted_size"] = least;
  return result;
}

}  // namespace palpate::experiments

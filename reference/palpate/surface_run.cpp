// palpate.surface at the door.
#include <array>
#include <cmath>
#include <cstdio>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/base/stopwatch.h"
#include "core/mesh/io/medit.h"
#include "core/simplify/surface/surface.h"
#include "reference/door/request_options.h"
#include "reference/palpate/methods.h"
#include "reference/palpate/objective.h"
#include "reference/palpate/wanted_sizes.h"
#include "reference/simplifier_support/fusion_run.h"

namespace palpate::reference {
namespace {

using nlohmann::json;

/// The options, how many metres a unit of the mesh is, and the file of wanted sizes.
struct SurfaceRequest {
  simplify::SurfaceOptions options;
  double max_error_m = 0.0;
  double unit_m = 1.0;
  std::filesystem::path sizes;  ///< empty: none
};

SurfaceRequest read_surface_options(const Request& request) {
  json left = request.options;
  SurfaceRequest result;
  result.options.stop = read_stop(request.stop);
  result.max_error_m = take_option<double>(left, "max_surface_error_m", &json::is_number, "a number", 0.0);
  result.unit_m = take_option<double>(left, "unit_m", &json::is_number, "a number", 1.0);
  if (!(result.unit_m > 0.0 && std::isfinite(result.unit_m))) {
    throw InputError("unit_m", 0, "metres in a unit of the mesh, above 0", std::to_string(result.unit_m));
  }
  result.options.max_surface_error = result.max_error_m / result.unit_m;
  result.options.objective = take_objective(left, {"shape", "quality", "stable_step"});
  result.options.effort =
      take_option<int>(left, "effort", &json::is_number_integer, "a whole number", result.options.effort);
  result.options.sparing =
      take_option<bool>(left, "sparing", &json::is_boolean, "true or false", result.options.sparing);
  result.options.boundary_size =
      take_option<double>(left, "boundary_size", &json::is_number, "a number", result.options.boundary_size);
  result.options.boundary_flips = take_option<bool>(left, "boundary_flips", &json::is_boolean,
                                                    "true or false", result.options.boundary_flips);
  result.options.boundary_smoothing = take_option<bool>(left, "boundary_smoothing", &json::is_boolean,
                                                        "true or false", result.options.boundary_smoothing);
  result.options.feature_deg = take_option<double>(left, "feature_deg", &json::is_number, "a number", 0.0);
  result.options.sizing = take_sizing_options(request.keep, left);
  result.sizes = take_sizes_file(left);
  require_all_taken(left);
  simplify::validate_options(result.options);
  return result;
}

std::string contact_note(const Vec3& place) {
  std::array<char, 96> at{};
  std::snprintf(at.data(), at.size(), "(%.6g, %.6g, %.6g)", place.x, place.y, place.z);
  return std::string("the input's skin meets itself, one place is near ") + at.data() +
         ": no new contact was made, but the output is not promised to be free of such places";
}

/// What was kept of the sharp edges, for the notes and the report.
void report_features(const simplify::SurfaceRunReport& report, double degrees, Response& response) {
  std::string angle;
  append_number(angle, degrees);
  response.notes.push_back(report.feature_edges_in == 0
                               ? "no edge of the skin is sharper than " + angle + " degrees"
                               : std::to_string(report.feature_edges_in) + " edges are sharper than " +
                                     angle + " degrees: kept as lines of " +
                                     std::to_string(report.feature_edges_out) + " edges, with " +
                                     std::to_string(report.feature_corners) + " corners");
  response.report["feature_edges_in"] = report.feature_edges_in;
  response.report["feature_edges_out"] = report.feature_edges_out;
  response.report["feature_corners"] = report.feature_corners;
  response.report["rejected"]["feature"] = report.surface.rejected_feature;
}

/// What ends above the count is run anew, as far as it goes.
simplify::SurfaceRunReport coarsen(TetMesh& mesh, const simplify::SurfaceOptions& options,
                                   const std::filesystem::path& input) {
  simplify::SurfaceRunReport report = simplify::simplify_surface(mesh, options);
  if (report.stop != "limit" || (!options.stop.tets && !options.stop.ratio)) return report;
  mesh = read_medit(input).mesh;
  return simplify::simplify_surface_to_limit(mesh, options);
}

}  // namespace

Response run_surface(const Request& request) {
  SurfaceRequest asked = read_surface_options(request);
  MeditFile file = read_medit(request.input);
  Response response;
  response.notes = std::move(file.notes);
  const Stopwatch watch;
  asked.options.sizing.sizes = load_sizes(asked.sizes, file.mesh);
  const simplify::SurfaceRunReport report = coarsen(file.mesh, asked.options, request.input);
  response.kernel_s = watch.seconds();
  write_medit(request.output, file.mesh);
  std::string note = "surface within ";
  append_number(note, asked.max_error_m);
  note += " m of the input's: ";
  append_number(note, asked.options.max_surface_error);
  note += " units of ";
  append_number(note, asked.unit_m);
  response.notes.push_back(note + " m");
  if (report.input_contact) response.notes.push_back(contact_note(*report.input_contact));
  response.report = {{"method", request.method},
                     {"input_meets_itself", report.input_contact.has_value()},
                     {"vertices_in", report.vertices_in},
                     {"vertices_out", report.vertices_out},
                     {"tets_in", report.tets_in},
                     {"tets_out", report.tets_out},
                     {"fusions", 0},
                     {"collapses", report.inner.collapses},
                     {"boundary_collapses", report.surface.collapses},
                     {"boundary_splits", report.surface.splits},
                     {"boundary_flips", report.surface.flips},
                     {"boundary_moves", report.surface.moves},
                     {"boundary_faces_in", report.boundary_faces_in},
                     {"boundary_faces_out", report.boundary_faces_out},
                     {"max_surface_error_unit", asked.options.max_surface_error},
                     {"volume_drift_relative", report.volume_drift_relative},
                     {"stop", report.stop},
                     {"rejected",
                      {{"link", report.inner.rejected_link},
                       {"shape", report.inner.rejected_shape},
                       {"boundary_link", report.surface.rejected_link},
                       {"boundary_shape", report.surface.rejected_shape},
                       {"distance", report.surface.rejected_distance},
                       {"contact", report.surface.rejected_contact}}}};
  if (asked.options.feature_deg > 0.0) report_features(report, asked.options.feature_deg, response);
  return response;
}

}  // namespace palpate::reference

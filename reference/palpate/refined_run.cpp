// palpate.refined at the door.

#include <array>

#include "core/base/stopwatch.h"
#include "core/mesh/io/medit.h"
#include "core/simplify/refined/refined.h"
#include "reference/door/request_options.h"
#include "reference/palpate/methods.h"
#include "reference/palpate/objective.h"
#include "reference/palpate/wanted_sizes.h"
#include "reference/simplifier_support/fusion_run.h"

namespace palpate::reference {
namespace {

using nlohmann::json;

bool take_switch(json& options, const char* key, bool fallback) {
  return take_option<bool>(options, key, &json::is_boolean, "true or false", fallback);
}

/// The options, and the file of wanted sizes if there is one.
struct RefinedRequest {
  simplify::RefinedOptions options;
  std::filesystem::path sizes;
};

RefinedRequest read_refined_options(const Request& request) {
  json left = request.options;
  RefinedRequest result;
  simplify::RefinedOptions& options = result.options;
  options.stop = read_stop(request.stop);
  options.effort =
      take_option<int>(left, "effort", &json::is_number_integer, "a whole number", options.effort);
  constexpr std::array kPlacements{simplify::CollapsePlacement::kFirst, simplify::CollapsePlacement::kBest,
                                   simplify::CollapsePlacement::kMidpoint};
  options.collapse_placement =
      kPlacements[take_choice(left, "collapse_placement", {"first", "best", "midpoint"})];
  options.objective = take_objective(left, {"shape", "quality", "stable_step"});
  simplify::RepairTools& tools = options.tools;
  options.interleave = take_switch(left, "interleave", options.interleave);
  options.repair = take_switch(left, "repair", options.repair);
  tools.smoothing = take_switch(left, "smoothing", tools.smoothing);
  tools.edge_removal = take_switch(left, "edge_removal", tools.edge_removal);
  tools.face_removal = take_switch(left, "face_removal", tools.face_removal);
  tools.compound_moves = take_switch(left, "compound_moves", tools.compound_moves);
  tools.edge_splits = take_switch(left, "edge_splits", tools.edge_splits);
  tools.insertions = take_switch(left, "insertions", tools.insertions);
  tools.never_worse = take_switch(left, "never_worse", tools.never_worse);
  options.sizing = take_sizing_options(request.keep, left);
  result.sizes = take_sizes_file(left);
  require_all_taken(left);
  simplify::validate_options(options);
  return result;
}

}  // namespace

Response run_refined(const Request& request) {
  const RefinedRequest asked = read_refined_options(request);
  simplify::RefinedOptions options = asked.options;
  MeditFile file = read_medit(request.input);
  Response response;
  response.notes = std::move(file.notes);
  const Stopwatch watch;
  options.sizing.sizes = load_sizes(asked.sizes, file.mesh);
  options.abandon_beyond = simplify::kShort;  // there is another way
  simplify::RefinedReport report = simplify::simplify_refined(file.mesh, options);
  if (report.stop == "limit") {
    file.mesh = read_medit(request.input).mesh;
    report = simplify::simplify_to_limit(file.mesh, options);
  }
  response.kernel_s = watch.seconds();
  write_medit(request.output, file.mesh);
  response.report = {
      {"method", request.method},
      {"vertices_in", report.vertices_in},
      {"vertices_out", report.vertices_out},
      {"tets_in", report.tets_in},
      {"tets_out", report.tets_out},
      {"fusions", 0},
      {"collapses", report.collapses.collapses},
      {"moves", report.counts.moves},
      {"edges_removed", report.counts.edges_removed},
      {"faces_removed", report.counts.faces_removed},
      {"splits", report.counts.splits},
      {"insertions", report.counts.insertions},
      {"stop", report.stop},
      {"rejected", {{"link", report.collapses.rejected_link}, {"shape", report.collapses.rejected_shape}}}};
  return response;
}

}  // namespace palpate::reference

#include "reference/simplifier_support/fusion_run.h"

#include <array>

#include "core/base/stopwatch.h"
#include "core/mesh/io/medit.h"
#include "core/simplify/sizing/kept_region_text.h"

namespace palpate::reference {

using nlohmann::json;

simplify::StopRule read_stop(const json& stop) {
  simplify::StopRule rule;
  for (const auto& [kind, value] : stop.items()) {
    if (kind == "fusions" && value.is_number_unsigned()) {
      rule.fusions = value.get<std::uint64_t>();
    } else if (kind == "tets" && value.is_number_unsigned()) {
      rule.tets = value.get<std::uint64_t>();
    } else if (kind == "ratio" && value.is_number()) {
      rule.ratio = value.get<double>();
    } else if (!(kind == "limit" && value == true)) {
      throw InputError("stop", 0, "fusions, tets, ratio or limit with a value that fits",
                       kind + ": " + value.dump());
    }
  }
  return rule;
}

simplify::SimplifyOptions take_fusion_options(const json& stop, json& options) {
  using simplify::IdealVolume;
  using simplify::LevelAdjacency;
  simplify::SimplifyOptions result;
  result.stop = read_stop(stop);
  constexpr std::array kLevels{LevelAdjacency::kVertex, LevelAdjacency::kEdge, LevelAdjacency::kFace};
  result.levels = kLevels[take_choice(options, "levels", {"vertex", "edge", "face"})];
  result.drop = take_option<double>(options, "drop", &json::is_number, "a number", result.drop);
  constexpr std::array kIdeal{IdealVolume::kFixed, IdealVolume::kUpdated};
  result.ideal_volume = kIdeal[take_choice(options, "ideal_volume", {"fixed", "updated"})];
  result.skip_touched =
      take_option<bool>(options, "skip_touched", &json::is_boolean, "true or false", result.skip_touched);
  result.last_level =
      take_option<int>(options, "last_level", &json::is_number_integer, "a whole number", result.last_level);
  constexpr std::array<simplify::FusionChecks, 4> kChecks{
      {{true, true}, {true, false}, {false, true}, {false, false}}};
  result.checks = kChecks[take_choice(options, "checks", {"all", "flip", "quality", "none"})];
  constexpr std::array kMetrics{simplify::kThesisMetric, simplify::kMeanRatioMetric};
  result.metric = kMetrics[take_choice(options, "metric", {"thesis", "mean_ratio"})];
  return result;
}

simplify::SizingOptions take_sizing_options(const std::vector<std::string>& keep, json& options) {
  simplify::SizingOptions sizing;
  for (const std::string& region : keep) sizing.keep.push_back(simplify::parse_kept_region(region, "keep"));
  sizing.near_size =
      take_option<double>(options, "near_size", &json::is_number, "a number", sizing.near_size);
  sizing.reach = take_option<double>(options, "reach", &json::is_number, "a number", sizing.reach);
  return sizing;
}

Response run_fusion(const Request& request,
                    const std::function<simplify::SimplifyReport(TetMesh&)>& simplify) {
  MeditFile file = read_medit(request.input);
  Response response;
  response.notes = std::move(file.notes);
  const Stopwatch watch;
  const simplify::SimplifyReport report = simplify(file.mesh);
  response.kernel_s = watch.seconds();
  write_medit(request.output, file.mesh);
  if (report.fusions == 0 && report.stop == "limit") {
    response.notes.emplace_back("no tetrahedron can be fused: the mesh is left as it is");
  }
  response.report = {{"method", request.method},
                     {"vertices_in", report.vertices_in},
                     {"vertices_out", report.vertices_out},
                     {"tets_in", report.tets_in},
                     {"tets_out", report.tets_out},
                     {"fusions", report.fusions},
                     {"stop", report.stop},
                     {"levels", report.level_sizes},
                     {"rejected",
                      {{"boundary", report.rejected.boundary},
                       {"boundary_neighbour", report.rejected.boundary_neighbour},
                       {"quality", report.rejected.quality},
                       {"flip", report.rejected.flip},
                       {"touched", report.rejected.touched},
                       {"kept", report.rejected.kept}}}};
  return response;
}

}  // namespace palpate::reference

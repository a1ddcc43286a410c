#include "experiments/gates/accept.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <set>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "experiments/judging/measure.h"
#include "experiments/records/provenance.h"
#include "experiments/records/run_folder.h"
#include "reference/door/json_file.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

/// Counts and flags that a valid answer has exactly.
constexpr std::array kValidityMeasures{"inverted_tets",
                                       "flat_tets",
                                       "duplicate_tets",
                                       "nonmanifold_faces",
                                       "folded_faces",
                                       "nonmanifold_edges",
                                       "nonmanifold_vertices",
                                       "isolated_vertices",
                                       "boundary_changed_faces",
                                       "kept_tets_changed",
                                       "surface_self_intersections",
                                       "euler_unchanged",
                                       "components_unchanged"};

FigureKind kind_of_measure(const std::string& measure) {
  if (is_stability_measure(measure)) return FigureKind::kStability;
  const bool is_validity =
      std::find(kValidityMeasures.begin(), kValidityMeasures.end(), measure) != kValidityMeasures.end();
  return is_validity ? FigureKind::kValidity : FigureKind::kAccuracy;
}

std::string share_text(double from, double to) {
  if (from == 0.0) return "";
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%+.3g%%", 100.0 * (to - from) / std::fabs(from));
  return text.data();
}

ordered_json figure_of_measure(const std::string& id, const Measure& measure, FigureKind kind) {
  ordered_json figure = {
      {"kind", kFigureKindNames.of(kind)}, {"case", id}, {"measure", measure.name}, {"value", nullptr}};
  if (kind != FigureKind::kValidity) figure["lower"] = 0;
  if (kind == FigureKind::kAccuracy) figure["upper"] = 0;
  figure["unit"] = measure.unit;
  return figure;
}

/// Whether a case that the run has has at least two repeats, and all of them gave one output.
bool repeats_agree(const RunRows& rows, const std::string& id) {
  const auto own = rows.of_case(id);
  const std::string* hash = own.front()->output_hash;
  return own.size() >= 2 && hash != nullptr && !hash->empty() &&
         std::all_of(own.begin(), own.end(), [&](const RunRow* row) { return row->output_hash == hash; });
}

}  // namespace

std::string AcceptedChange::text() const {
  return name + ": " + from + " -> " + to + (share.empty() ? "" : " (" + share + ")");
}

std::vector<AcceptedChange> update_accepted(const GateResult& result,
                                            const std::filesystem::path& accepted_file) {
  AcceptedFile accepted = read_accepted(accepted_file, result.plan);
  require(accepted.figures.size() == result.lines.size(), "update_accepted: another file");
  std::vector<AcceptedChange> changes;
  for (std::size_t i = 0; i < result.lines.size(); ++i) {
    const GateLine& line = result.lines[i];
    const AcceptedFigure& figure = line.figure;
    ordered_json& entry = accepted.data["figures"][i];
    if (figure.is_word()) {
      if (line.measured_word.empty() || line.measured_word == figure.word) continue;
      entry[figure.kind == FigureKind::kHash ? "value" : "outcome"] = line.measured_word;
      changes.push_back({figure.name(), figure.word.empty() ? "none" : figure.word, line.measured_word, ""});
      continue;
    }
    if (!line.measured || line.measured == figure.value) continue;
    entry["value"] = *line.measured;
    const std::string unit = figure.unit.empty() || figure.unit == "1" ? "" : " " + figure.unit;
    changes.push_back({figure.name(), figure.value ? short_number(*figure.value) : "none",
                       short_number(*line.measured) + unit,
                       figure.value ? share_text(*figure.value, *line.measured) : ""});
  }
  if (!changes.empty()) write_file_atomically(accepted_file, accepted.data.dump(2) + "\n");
  return changes;
}

std::vector<FigureKind> default_kinds() {
  return {FigureKind::kAccuracy, FigureKind::kValidity, FigureKind::kStability, FigureKind::kHash};
}

std::vector<const Measure*> measures_to_propose(const json& provenance) {
  std::vector<const Measure*> measures;
  const json plan = provenance.is_object() ? provenance.value("plan_data", json()) : json();
  if (!plan.is_object()) return measures;
  const auto add = [&](const std::string& name) {
    const Measure* measure = find_measure(name);
    if (measure == nullptr || !measure->scalar || is_measured_anew(*measure)) return;
    if (std::find(measures.begin(), measures.end(), measure) == measures.end()) measures.push_back(measure);
  };
  for (const json& name : plan.value("measure", json::array())) {
    if (name.is_string()) add(name.get<std::string>());
  }
  const json accept = plan.value("accept", json::object());
  for (const auto& [name, bound] : accept.items()) add(name);
  return measures;
}

ordered_json propose_accepted(const std::filesystem::path& folder, const RunRows& rows,
                              const std::string& plan, const std::vector<FigureKind>& kinds) {
  const auto wanted = [&](FigureKind kind) {
    return std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
  };
  for (const FigureKind kind : {FigureKind::kComparison, FigureKind::kTimeRatio}) {
    if (wanted(kind))
      throw InputError(std::string("a ") + kFigureKindNames.of(kind) +
                       " is for you to write: no run says which cases are to be held against each other");
  }
  const auto measures = measures_to_propose(read_provenance(RunPaths{folder}.provenance()));
  ordered_json figures = ordered_json::array();
  std::set<std::string> done;
  for (const RunRow& row : rows.all()) {
    const std::string& id = *row.run_case;
    if (*row.outcome != "accepted" || !done.insert(id).second) continue;
    if (wanted(FigureKind::kValidity) && row.is_answer)
      figures.push_back({{"kind", "validity"}, {"case", id}, {"outcome", nullptr}});
    for (const Measure* measure : measures) {
      const FigureKind kind = kind_of_measure(measure->name);
      if (wanted(kind) && rows.figure(row, *measure))
        figures.push_back(figure_of_measure(id, *measure, kind));
    }
    if (wanted(FigureKind::kHash) && row.is_answer && repeats_agree(rows, id))
      figures.push_back({{"kind", "hash"}, {"case", id}, {"value", nullptr}});
  }
  if (figures.empty())
    throw InputError(folder.string(), 0, "a run with figures of these kinds, of measures that its plan names",
                     "none");
  return {{"schema", "palpate/accepted/2"}, {"plan", plan}, {"figures", std::move(figures)}};
}

}  // namespace palpate::experiments

#include "experiments/plan_report.h"

#include <algorithm>

#include "experiments/nearest_name.h"

namespace palpate::experiments {
namespace {

const std::vector<std::string> kCharts{"histograms",   "overview", "timing",
                                       "quality_time", "scaling",  "cut_away"};
const std::vector<std::string> kDeformCharts{"error_bars", "error_time", "convergence", "simplified_error"};
const std::vector<std::string> kMotionCharts{"motion_errors", "motion_histories"};

std::string known_label(const YamlValue& value, const std::vector<PlanContestant>& contestants) {
  std::vector<std::string> labels;
  labels.reserve(contestants.size());
  for (const PlanContestant& contestant : contestants) labels.push_back(contestant.label);
  std::string label = value.text();
  if (std::find(labels.begin(), labels.end(), label) == labels.end()) {
    value.fail("unknown label \"" + label + "\"" + nearest_hint(label, labels));
  }
  return label;
}

/// Appends a name, refusing one that is there already.
void add_once(const YamlValue& at, const char* what, std::string name, std::vector<std::string>& names) {
  if (std::find(names.begin(), names.end(), name) != names.end()) {
    at.fail(std::string(what) + " \"" + name + "\" twice");
  }
  names.push_back(std::move(name));
}

Comparison read_comparison(const YamlValue& value, const std::vector<PlanContestant>& contestants) {
  const YamlFields fields =
      value.fields({"of", "against_best_of", "measures", "time_against", "time_factor", "input_up_to_ratio"});
  Comparison comparison;
  comparison.of = known_label(fields.need("of"), contestants);
  const YamlValue against = fields.need("against_best_of");
  for (const YamlValue& item : against.items()) {
    std::string label = known_label(item, contestants);
    if (label == comparison.of) item.fail("\"" + label + "\" cannot be compared with itself");
    add_once(item, "label", std::move(label), comparison.against_best_of);
  }
  if (comparison.against_best_of.empty()) against.fail_expected("at least one label");
  const YamlValue measures = fields.need("measures");
  for (const YamlValue& item : measures.items()) {
    const Measure& measure = known_measure(item, item.text(), true);
    if (std::string(measure.better).empty()) {
      item.fail(std::string("of the measure \"") + measure.name + "\" neither more nor less is better");
    }
    add_once(item, "measure", measure.name, comparison.measures);
  }
  if (comparison.measures.empty()) measures.fail_expected("at least one measure");
  const auto time_against = fields.find("time_against");
  const auto time_factor = fields.find("time_factor");
  if (time_against) comparison.time_against = known_label(*time_against, contestants);
  if (time_factor && !time_against) time_factor->fail("\"time_factor\" needs \"time_against\"");
  if (time_factor) comparison.time_factor = time_factor->number(1e-6, 1e6);
  if (const auto ratio = fields.find("input_up_to_ratio")) comparison.input_up_to_ratio = ratio->number(0, 1);
  return comparison;
}

}  // namespace

const Measure& known_measure(const YamlValue& at, const std::string& name, bool scalar) {
  const Measure* measure = find_measure(name);
  if (measure == nullptr) at.fail("unknown measure \"" + name + "\"" + nearest_hint(name, measure_names()));
  if (scalar && !measure->scalar) at.fail("measure \"" + name + "\" is a list, a single number is needed");
  return *measure;
}

AcceptBound read_bound(const std::string& measure, const YamlValue& value) {
  known_measure(value, measure, true);
  const YamlFields fields = value.fields({"min", "max"});
  AcceptBound bound{measure, std::nullopt, std::nullopt};
  if (const auto min = fields.find("min")) bound.min = min->number();
  if (const auto max = fields.find("max")) bound.max = max->number();
  if (!bound.min && !bound.max) value.fail(measure + ": expected min or max");
  if (bound.min && bound.max && *bound.min > *bound.max) value.fail(measure + ": min is above max");
  return bound;
}

Claim read_claim(const YamlValue& value, const std::vector<PlanContestant>& contestants) {
  const YamlFields fields =
      value.fields({"text", "source", "measure", "better", "than", "spread", "published"});
  Claim claim;
  claim.text = fields.need("text").text();
  if (const auto source = fields.find("source")) claim.source = source->text();
  const YamlValue measure = fields.need("measure");
  claim.measure = known_measure(measure, measure.text(), true).name;
  claim.better = known_label(fields.need("better"), contestants);
  claim.than = known_label(fields.need("than"), contestants);
  if (const auto spread = fields.find("spread")) claim.spread = known_label(*spread, contestants);
  if (const auto published = fields.find("published")) {
    const YamlFields figures = published->fields({"better", "than"});
    claim.published_better = figures.need("better").number();
    claim.published_than = figures.need("than").number();
  }
  return claim;
}

std::vector<Comparison> read_comparisons(const YamlValue& value,
                                         const std::vector<PlanContestant>& contestants) {
  std::vector<Comparison> comparisons;
  for (const YamlValue& item : value.items()) comparisons.push_back(read_comparison(item, contestants));
  if (comparisons.empty()) value.fail_expected("at least one comparison");
  return comparisons;
}

std::vector<std::string> read_charts(const YamlValue& value, const std::string& contest) {
  const std::vector<std::string>& known =
      contest == "deform" ? kDeformCharts : (contest == "motion" ? kMotionCharts : kCharts);
  std::vector<std::string> charts;
  for (const YamlValue& item : value.items()) {
    const std::string name = item.text();
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      item.fail("unknown chart \"" + name + "\"" + nearest_hint(name, known));
    }
    add_once(item, "chart", name, charts);
  }
  return charts;
}

}  // namespace palpate::experiments

#include "experiments/contests/simplify/plan_simplify.h"

#include "experiments/judging/judge_record.h"
#include "experiments/judging/kept_regions.h"
#include "experiments/plan_reader/plan_contestant.h"
#include "experiments/plan_reader/plan_mesh.h"
#include "experiments/plan_reader/plan_report.h"
#include "experiments/text/nearest_name.h"

namespace palpate::experiments {
namespace {

Comparison read_comparison(const YamlValue& value, const std::vector<PlanContestant>& contestants,
                           const RunSettings& run) {
  const YamlFields fields = value.fields({"of", "against_best_of", "measures", "time_against", "time_factor",
                                          "input_up_to_ratio", "equal_distance", "required"});
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
    if (is_clock_time(measure.name)) require_repeats(item, run);
    add_once(item, "measure", measure.name, comparison.measures);
  }
  if (comparison.measures.empty()) measures.fail_expected("at least one measure");
  const auto time_against = fields.find("time_against");
  const auto time_factor = fields.find("time_factor");
  if (time_against) {
    comparison.time_against = known_label(*time_against, contestants);
    require_repeats(*time_against, run);
  }
  if (time_factor && !time_against) time_factor->fail("\"time_factor\" needs \"time_against\"");
  if (time_factor) comparison.time_factor = time_factor->number(1e-6, 1e6);
  if (const auto ratio = fields.find("input_up_to_ratio")) comparison.input_up_to_ratio = ratio->number(0, 1);
  if (const auto near = fields.find("equal_distance")) near->boolean();  // the report reads it
  check_required(fields);
  return comparison;
}

Claim read_claim(const YamlValue& value, const std::vector<PlanContestant>& contestants) {
  const YamlFields fields =
      value.fields({"text", "source", "measure", "better", "than", "spread", "published", "required"});
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
  check_required(fields);
  return claim;
}

std::vector<Comparison> read_comparisons(const YamlValue& value,
                                         const std::vector<PlanContestant>& contestants,
                                         const RunSettings& run) {
  std::vector<Comparison> comparisons;
  for (const YamlValue& item : value.items()) comparisons.push_back(read_comparison(item, contestants, run));
  if (comparisons.empty()) value.fail_expected("at least one comparison");
  return comparisons;
}

/// A measure of sharp edges, wherever the plan names one, needs the angle.
void require_feature_deg(const YamlFields& fields, const Plan& plan, const SimplifyPart& part) {
  const auto check = [](const YamlValue& at, const std::string& name) {
    if (is_of_features(name)) at.fail("the measure \"" + name + "\" needs the plan's \"feature_deg\"");
  };
  if (const auto measure = fields.find("measure")) {
    for (const YamlValue& item : measure->items()) check(item, item.text());
  }
  if (const auto accept = fields.find("accept")) {
    for (const auto& [name, entry] : accept->entries()) check(entry, name);
  }
  if (part.claim) check(fields.need("claim"), part.claim->measure);
  for (const std::string& name : plan.compared) check(fields.need("comparisons"), name);
}

}  // namespace

void read_simplify_plan(const YamlFields& fields, Plan& plan, const Registry& registry) {
  plan.meshes = read_meshes(fields.need("meshes"), plan.file.parent_path());
  plan.subjects = names_of(plan.meshes);
  if (const auto sweep = fields.find("sweep"))
    plan.sweep = read_sweep(*sweep, {"tets_removed_ratio", "fusions", "tets"});
  plan.contestants = read_contestants(fields.need("contestants"), "simplify", plan.sweep, registry);
  for (const PlanContestant& contestant : plan.contestants) {
    if (contestant.grade)
      fields.need("contestants")
          .fail("\"grade\" of " + contestant.label +
                " needs a scene: it belongs to simplifiers of the contest deform");
  }
  auto part = std::make_shared<SimplifyPart>();
  if (const auto region = fields.find("region")) part->region = read_kept_regions(*region);
  if (const auto equal_count = fields.find("equal_count")) part->equal_count = equal_count->number(1e-6, 0.1);
  if (const auto claim = fields.find("claim")) part->claim = read_claim(*claim, plan.contestants);
  if (const auto comparisons = fields.find("comparisons"))
    part->comparisons = read_comparisons(*comparisons, plan.contestants, plan.run);
  for (const Comparison& comparison : part->comparisons)
    plan.compared.insert(plan.compared.end(), comparison.measures.begin(), comparison.measures.end());
  if (const auto degrees = fields.find("feature_deg")) {
    part->feature_deg = degrees->number(0.0, 180.0);
    if (*part->feature_deg == 0.0 || *part->feature_deg == 180.0)
      degrees->fail_expected("degrees between 0 and 180");
  } else {
    require_feature_deg(fields, plan, *part);
  }
  plan.part = std::move(part);
}

}  // namespace palpate::experiments

#include "experiments/plan_reader/plan_reference.h"

#include "experiments/plan_reader/plan_contestant.h"

namespace palpate::experiments {
namespace {

constexpr std::int64_t kMostLevels = 4;

}  // namespace

PlanReference read_reference(const YamlValue& value, const std::string& contest, const Registry& registry) {
  const YamlFields fields = value.fields({"method", "levels", "enough", "stated_order", "set"});
  if (contest == "motion") {
    if (const auto extra = fields.find("enough"))
      extra->fail("\"enough\" belongs to the contest deform, not to motion");
  }
  PlanReference reference;
  const YamlValue method = fields.need("method");
  reference.method = method.text();
  const MethodEntry entry = find_method(method, reference.method, contest, registry);
  const OptionSpec* refine = entry.method->find_option("refine");
  if (refine == nullptr || refine->type != OptionType::kInteger)
    method.fail("method " + reference.method + " has no integer option \"refine\", as a reference needs");
  if (contest == "motion" && entry.method->find_option("time_step_s") == nullptr)
    method.fail("method " + reference.method + " has no option \"time_step_s\", as a reference needs");
  if (const auto set = fields.find("set")) reference.set = read_set(*set, *entry.method);
  if (reference.set.count("refine") > 0) value.fail("the option \"refine\" follows from \"levels\"");
  if (const auto levels = fields.find("levels"))
    reference.levels = static_cast<int>(levels->integer(contest == "motion" ? 2 : 1, kMostLevels));
  if (const auto enough = fields.find("enough")) reference.enough = enough->number(1e-12, 1.0);
  if (const auto order = fields.find("stated_order")) reference.stated_order = order->number(1.0, 4.0);
  return reference;
}

void check_reserved_labels(const YamlValue& contestants, const Plan& plan) {
  for (const PlanContestant& contestant : plan.contestants) {
    if (contestant.label == "reference")
      contestants.fail("the label \"reference\" stands for the reference itself");
  }
}

}  // namespace palpate::experiments

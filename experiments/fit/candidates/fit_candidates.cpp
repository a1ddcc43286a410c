#include "experiments/fit/candidates/fit_candidates.h"

#include <algorithm>
#include <limits>
#include <set>

#include "core/dynamics/motion/integrator_kind.h"
#include "experiments/files/places.h"
#include "experiments/plan_reader/plan.h"
#include "experiments/plan_reader/plan_contestant.h"
#include "experiments/text/nearest_name.h"
#include "experiments/text/yaml_schema.h"
#include "reference/door/moving_body.h"

namespace palpate::experiments {
namespace {

constexpr const char* kSkinBound = "max_surface_error_m";

const std::vector<std::string>& known_works() {
  static const std::vector<std::string> works{work_name(FitWork::kFirst), work_name(FitWork::kFurther),
                                              work_name(FitWork::kSecond)};
  return works;
}

void require_known(const YamlValue& at, const char* what, const std::string& name,
                   const std::vector<std::string>& known) {
  if (std::find(known.begin(), known.end(), name) == known.end())
    at.fail(std::string("unknown ") + what + " \"" + name + "\"" + nearest_hint(name, known));
}

FitSimplifier read_fit_simplifier(const YamlValue& value, const Registry& registry) {
  const YamlFields fields = value.fields({"label", "method", "set", "ratios", "grade", "skin_within"});
  FitSimplifier simplifier;
  simplifier.label = fields.need("label").identifier();
  const YamlValue method = fields.need("method");
  simplifier.method = method.text();
  const MethodEntry entry = find_method(method, simplifier.method, "simplify", registry);
  if (const auto set = fields.find("set")) {
    read_set(*set, *entry.method);
    simplifier.set = set->json();
  }
  for (const YamlValue& ratio : fields.need("ratios").items())
    simplifier.ratios.push_back(ratio.number(0.0, 0.999));
  if (simplifier.ratios.empty()) fields.need("ratios").fail_expected("at least one share");
  if (const auto within = fields.find("skin_within")) {
    constexpr double kMost = 0.1;  // what strays farther is another body
    if (entry.method->find_option(kSkinBound) == nullptr)
      within->fail("method " + simplifier.method + " has no option \"" + kSkinBound +
                   "\": its skin has no bound");
    if (simplifier.set.contains(kSkinBound))
      within->fail(std::string("the option \"") + kSkinBound + "\" is set too: one bound, or the other");
    simplifier.skin_within = within->number(0.0, kMost);
  }
  if (const auto grade = fields.find("grade")) {
    simplifier.grade = read_grade(*grade, registry);
    if (entry.method->find_option("sizes") == nullptr)
      grade->fail("method " + simplifier.method + " has no option \"sizes\": it cannot be graded");
    if (simplifier.ratios.size() != 1)
      fields.need("ratios").fail_expected("one share: sizes are for one count");
  }
  return simplifier;
}

FitModel read_fit_model(const YamlValue& value, const Registry& registry) {
  std::vector<std::string> abilities = changeable_things();
  abilities.emplace_back("large_strain");
  const YamlFields fields = value.fields({"label", "method", "set", "works"});
  FitModel model;
  model.label = fields.need("label").identifier();
  const YamlValue method = fields.need("method");
  model.method = method.text();
  const MethodEntry entry = find_method(method, model.method, "deform", registry);
  model.set = nlohmann::json::object();
  if (const auto set = fields.find("set")) {
    read_set(*set, *entry.method);
    model.set = set->json();
  }
  for (const auto& [work, can] : fields.need("works").entries()) {
    require_known(can, "work", work, known_works());
    std::vector<std::string>& own = model.works[work];
    for (const YamlValue& item : can.items()) {
      require_known(item, "ability", item.text(), abilities);
      own.push_back(item.text());
    }
  }
  return model;
}

/// What may change is said, or follows from the integrator: explicit steps ask the forces alone, all others
/// are taken to keep factors or tables.
std::vector<std::string> read_may_change(const YamlFields& fields, const std::string& integrator) {
  const std::vector<std::string>& things = changeable_things();
  std::vector<std::string> own;
  if (const auto given = fields.find("may_change")) {
    for (const YamlValue& item : given->items()) {
      require_known(item, "thing that may change", item.text(), things);
      if (std::find(own.begin(), own.end(), item.text()) != own.end())
        item.fail("\"" + item.text() + "\" twice");
      own.push_back(item.text());
    }
    return own;
  }
  if (integrator == reference::kExponential) return own;
  return is_implicit(dynamics::parse_integrator(integrator)) ? own : things;
}

FitStepping read_fit_stepping(const YamlValue& value) {
  const YamlFields fields =
      value.fields({"label", "integrator", "precision", "solver", "modes", "may_change"});
  FitStepping stepping;
  stepping.label = fields.need("label").identifier();
  const YamlValue integrator = fields.need("integrator");
  std::vector<std::string> known{reference::kExponential};
  known.reserve(dynamics::kIntegrators.size() + 1);
  for (const auto kind : dynamics::kIntegrators) known.emplace_back(dynamics::integrator_name(kind));
  stepping.integrator = integrator.text();
  require_known(integrator, "integrator", stepping.integrator, known);
  if (const auto precision = fields.find("precision")) {
    if (precision->text() != "single" && precision->text() != "double")
      precision->fail_expected("single or double");
    stepping.single_precision = precision->text() == "single";
  }
  if (const auto solver = fields.find("solver")) stepping.solver = solver->json();
  stepping.may_change = read_may_change(fields, stepping.integrator);
  const bool is_modal = stepping.integrator == reference::kExponential;
  const auto modes = fields.find("modes");
  if (is_modal != modes.has_value())
    value.fail(std::string("\"modes\" and the integrator ") + reference::kExponential + " go together");
  if (!is_modal) return stepping;
  stepping.modes = static_cast<std::size_t>(modes->integer(1, 1000));
  if (fields.find("precision") || fields.find("solver"))
    value.fail("exact steps have neither precision nor solver");
  return stepping;
}

/// Reads a list of things that have labels; one label belongs to one of them.
template <typename Thing, typename Read>
std::vector<Thing> read_labelled(const YamlValue& list, std::set<std::string>& labels, const Read& read) {
  std::vector<Thing> things;
  for (const YamlValue& item : list.items()) {
    things.push_back(read(item));
    if (!labels.insert(things.back().label).second) item.fail("this label is there already");
  }
  return things;
}

}  // namespace

const char* work_name(FitWork work) {
  switch (work) {
    case FitWork::kFirst:
      return "first";
    case FitWork::kFurther:
      return "further";
    case FitWork::kSecond:
      break;
  }
  return "second";
}

FitWork choose_work(const Scene& scene) {
  const SceneRequirement& require = *scene.require;
  if (require.time_per_second_s) return FitWork::kSecond;
  if (require.rate_hz) return FitWork::kFurther;
  if (require.answer_s) return FitWork::kFirst;
  return scene.is_dynamic ? FitWork::kSecond : FitWork::kFirst;
}

double budget_of(const SceneRequirement& require) {
  if (require.time_per_second_s) return *require.time_per_second_s;
  if (require.rate_hz) return 1.0 / *require.rate_hz;
  return require.answer_s.value_or(std::numeric_limits<double>::infinity());
}

std::string FitModel::cannot(FitWork work, const std::vector<std::string>& needs) const {
  const auto own = works.find(work_name(work));
  if (own == works.end()) return std::string("the work \"") + work_name(work) + "\"";
  for (const std::string& need : needs) {
    if (std::find(own->second.begin(), own->second.end(), need) == own->second.end()) return need;
  }
  return "";
}

FitCandidates read_candidates(const std::filesystem::path& path, const Registry& registry) {
  const YamlValue root = read_yaml(path);
  require_schema(root, "palpate/candidates/1");
  const YamlFields fields = root.fields({"schema", "simplifiers", "models", "steppings"});
  FitCandidates candidates;
  std::set<std::string> labels{kNoSimplifier};
  candidates.simplifiers = read_labelled<FitSimplifier>(
      fields.need("simplifiers"), labels,
      [&](const YamlValue& item) { return read_fit_simplifier(item, registry); });
  candidates.models = read_labelled<FitModel>(
      fields.need("models"), labels, [&](const YamlValue& item) { return read_fit_model(item, registry); });
  if (const auto steppings = fields.find("steppings"))
    candidates.steppings = read_labelled<FitStepping>(*steppings, labels, read_fit_stepping);
  const auto is_whole = [](const FitStepping& stepping) { return !stepping.modes; };
  if (!candidates.steppings.empty() &&
      std::none_of(candidates.steppings.begin(), candidates.steppings.end(), is_whole))
    fields.need("steppings").fail_expected("at least one that is not of modes");
  if (candidates.models.empty()) fields.need("models").fail_expected("at least one model");
  return candidates;
}

void set_skin_bounds(FitCandidates& candidates, double diagonal_m) {
  for (FitSimplifier& simplifier : candidates.simplifiers) {
    if (simplifier.skin_within) simplifier.set[kSkinBound] = *simplifier.skin_within * diagonal_m;
  }
}

void drop_steppings(std::vector<FitStepping>& steppings, const std::vector<std::string>& needs,
                    std::vector<std::string>& dropped) {
  std::vector<FitStepping> kept;
  for (FitStepping& stepping : steppings) {
    const std::string missing = stepping.cannot(needs);
    if (missing.empty()) {
      kept.push_back(std::move(stepping));
    } else if (!stepping.modes) {
      dropped.push_back(stepping.label + " (" + stepping.integrator +
                        " steps) are not tried: they need a new set-up for a change of " + missing);
    }
  }
  steppings = std::move(kept);
}

std::filesystem::path candidates_path() {
  return std::filesystem::path(source_folder()) / "experiments" / "fit" / "candidates.yaml";
}

}  // namespace palpate::experiments

#include "experiments/spring_training/training_plan.h"

#include <algorithm>

#include "experiments/text/nearest_name.h"
#include "experiments/text/yaml_schema.h"

namespace palpate::experiments {
namespace {

constexpr double kSpringRatio = 0.25;  // Poisson's ratio of springs alone
constexpr std::size_t kMostCases = 1000;

void require_new_name(const YamlValue& at, const std::string& name, const std::vector<std::string>& known) {
  if (std::find(known.begin(), known.end(), name) != known.end()) at.fail("\"" + name + "\" twice");
}

void read_clamps(const YamlValue& value, TrainingPlan& plan) {
  for (const auto& [name, list] : value.entries()) {
    require_new_name(list, name, names_of(plan.clamps));
    NamedClamps named{name, {}};
    for (const YamlValue& item : list.items()) named.clamps.push_back(read_scene_clamp(item));
    if (named.clamps.empty()) list.fail_expected("at least one clamp");
    plan.clamps.push_back(std::move(named));
  }
}

void read_named_loads(const YamlValue& value, TrainingPlan& plan) {
  for (const auto& [name, list] : value.entries()) {
    require_new_name(list, name, names_of(plan.loads));
    NamedLoads named{name, {}};
    bool acts = false;
    for (const YamlValue& item : list.items()) {
      named.loads.push_back(read_scene_load(item));
      acts = acts || length(named.loads.back().vector) > 0.0;
    }
    if (!acts) list.fail("load: expected one that does something, found none");
    plan.loads.push_back(std::move(named));
  }
}

std::vector<std::size_t> read_names(const YamlValue& value, const std::vector<std::string>& known) {
  std::vector<std::size_t> places;
  for (const YamlValue& item : value.items()) {
    const auto found = std::find(known.begin(), known.end(), item.text());
    if (found == known.end())
      item.fail("unknown name \"" + item.text() + "\"" + nearest_hint(item.text(), known));
    const auto place = static_cast<std::size_t>(found - known.begin());
    if (std::find(places.begin(), places.end(), place) != places.end())
      item.fail("\"" + item.text() + "\" twice");
    places.push_back(place);
  }
  if (places.empty()) value.fail_expected("at least one name");
  return places;
}

bool has(const std::vector<std::size_t>& places, std::size_t place) {
  return std::find(places.begin(), places.end(), place) != places.end();
}

/// Adds each of a block's clamps with each of its loads.
void read_block(const YamlValue& value, const TrainingPlan& plan, TrainingSplit& split) {
  const YamlFields keys = value.fields({"clamps", "loads"});
  const auto clamps = read_names(keys.need("clamps"), names_of(plan.clamps));
  const auto loads = read_names(keys.need("loads"), names_of(plan.loads));
  for (const std::size_t clamp : clamps)
    for (const std::size_t load : loads) {
      const TrainingPair pair{clamp, load};
      if (std::find(split.cases.begin(), split.cases.end(), pair) != split.cases.end())
        value.fail("\"" + plan.clamps[clamp].name + "\" with \"" + plan.loads[load].name + "\" twice");
      split.cases.push_back(pair);
    }
}

void read_split(const YamlFields& fields, const TrainingPlan& plan, TrainingSplit& split) {
  const YamlValue value = fields.need(split.name);
  if (value.is_list()) {
    for (const YamlValue& block : value.items()) read_block(block, plan, split);
  } else {
    read_block(value, plan, split);
  }
  if (split.cases.empty()) value.fail_expected("clamps and loads, or a list of such blocks");
  if (split.cases.size() > kMostCases) value.fail("too many cases: " + std::to_string(split.cases.size()));
}

std::vector<std::size_t> clamps_of(const TrainingSplit& split) {
  std::vector<std::size_t> clamps;
  for (const TrainingPair& pair : split.cases) clamps.push_back(pair.clamp);
  return clamps;
}

std::vector<std::size_t> loads_of(const TrainingSplit& split) {
  std::vector<std::size_t> loads;
  for (const TrainingPair& pair : split.cases) loads.push_back(pair.load);
  return loads;
}

// A test set's names must be ones that no choice looks at.
void require_apart(const YamlValue& at, const std::vector<std::size_t>& tested,
                   const std::vector<std::size_t>& seen, const std::vector<std::string>& names) {
  for (const std::size_t place : tested)
    if (has(seen, place))
      at.fail("\"" + names[place] + "\" is looked at by train or validate: a test set is apart from both");
}

void check_splits(const YamlFields& fields, const TrainingPlan& plan) {
  for (const TrainingSplit* seen : {&plan.train, &plan.validate}) {
    require_apart(fields.need("test_loads"), loads_of(plan.test_loads), loads_of(*seen),
                  names_of(plan.loads));
    require_apart(fields.need("test_clamps"), clamps_of(plan.test_clamps), clamps_of(*seen),
                  names_of(plan.clamps));
  }
  const auto trained = clamps_of(plan.train);
  for (const std::size_t clamp : clamps_of(plan.test_loads))
    if (!has(trained, clamp))
      fields.need("test_loads")
          .fail("\"" + plan.clamps[clamp].name +
                "\" is not among train's clamps: unseen clamps go into test_clamps");
  for (const TrainingPair& pair : plan.validate.cases)
    if (std::find(plan.train.cases.begin(), plan.train.cases.end(), pair) != plan.train.cases.end())
      fields.need("validate")
          .fail("\"" + plan.clamps[pair.clamp].name + "\" with \"" + plan.loads[pair.load].name +
                "\" is in train too: it validates nothing");
}

void read_springs(const YamlValue& value, TrainingPlan& plan) {
  const YamlFields keys = value.fields({"start", "face_opposite", "calibrate", "volume"});
  if (const auto start = keys.find("start")) plan.start = springs::parse_spring_method(start->text());
  if (const auto opposite = keys.find("face_opposite")) plan.face_opposite = opposite->boolean();
  if (const auto calibrate = keys.find("calibrate")) plan.calibrate = calibrate->boolean();
  if (const auto volume = keys.find("volume")) {
    const std::string name = volume->text();
    if (name != "none" && name != "tet" && name != "node_average")
      volume->fail_expected("none, tet or node_average");
    if (name == "tet") plan.volume = TrainedVolume::kTet;
    if (name == "node_average") plan.volume = TrainedVolume::kNodeAverage;
  }
}

void check_ratio(const YamlValue& material, const TrainingPlan& plan) {
  const double ratio = plan.material.poisson_ratio;
  if (plan.volume == TrainedVolume::kNone && ratio != kSpringRatio)
    material.fail("springs alone have Poisson's ratio 0.25, not " + std::to_string(ratio) +
                  ": name a volume model (springs: {volume: node_average})");
  if (plan.volume != TrainedVolume::kNone && ratio < kSpringRatio)
    material.fail(
        "a volume model carries what Poisson's ratio has above 0.25: expected at least that, found " +
        std::to_string(ratio));
}

void read_fit(const YamlValue& value, TrainingPlan& plan) {
  const YamlFields keys = value.fields({"ridges", "iterations"});
  const YamlValue ridges = keys.need("ridges");
  for (const YamlValue& item : ridges.items()) plan.ridges.push_back(item.number(0.0, 1e6));
  if (plan.ridges.empty()) ridges.fail_expected("at least one number");
  if (const auto iterations = keys.find("iterations"))
    plan.iterations = static_cast<std::size_t>(iterations->integer(1, 10000));
}

}  // namespace

TrainingPlan read_training_plan(const std::filesystem::path& path) {
  const YamlValue root = read_yaml(path);
  require_schema(root, "palpate/training/1");
  const YamlFields fields =
      root.fields({"schema", "mesh", "material", "springs", "reference", "fit", "clamps", "loads", "train",
                   "validate", "test_loads", "test_clamps"});
  TrainingPlan plan;
  plan.file = path;
  plan.mesh = read_scene_mesh(fields.need("mesh"), path.parent_path());
  plan.material = read_scene_material(fields.need("material"));
  if (const auto springs = fields.find("springs")) read_springs(*springs, plan);
  check_ratio(fields.need("material"), plan);
  if (const auto reference = fields.find("reference"))
    plan.refine = static_cast<int>(reference->fields({"refine"}).need("refine").integer(0, 3));
  read_fit(fields.need("fit"), plan);
  read_clamps(fields.need("clamps"), plan);
  read_named_loads(fields.need("loads"), plan);
  for (TrainingSplit* split : {&plan.train, &plan.validate, &plan.test_loads, &plan.test_clamps})
    read_split(fields, plan, *split);
  check_splits(fields, plan);
  return plan;
}

}  // namespace palpate::experiments

#include "experiments/envelope/fitted_folder.h"

#include <algorithm>
#include <limits>

#include "core/base/error.h"
#include "experiments/plan_reader/plan.h"
#include "experiments/text/yaml_value.h"
#include "reference/door/json_file.h"
#include "reference/door/moving_body.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

constexpr std::size_t kLargestFit = std::size_t{64} << 20U;
constexpr std::size_t kDepth = 64;

/// The simplifier of that label in the plan of the fit's search; the sizes of a graded one lie in the fit's
/// folder, wherever that is now.
FitSimplifier find_simplifier(const json& plan, const std::string& label, const fs::path& folder,
                              const fs::path& file) {
  for (const json& entry : plan.at("simplify")) {
    if (!entry.is_object() || entry.value("label", "") != label) continue;
    FitSimplifier found;
    found.label = label;
    found.method = entry.at("method").get<std::string>();
    found.set = entry.value("set", json::object());
    if (found.set.contains("sizes")) {
      const fs::path sizes = found.set.at("sizes").get<std::string>();
      found.set["sizes"] = fs::absolute(folder / "sizes" / sizes.filename()).string();
    }
    return found;
  }
  throw InputError(file.string() + ": simplify: the choice's simplifier \"" + label + "\" is not in it");
}

}  // namespace

FittedFolder read_fitted_folder(const fs::path& folder) {
  const fs::path fit_file = folder / "fit.json";
  if (!fs::exists(fit_file))
    throw InputError(folder.string(), 0, "a folder that palpate fit has written", "no fit.json in it");
  FittedFolder out;
  out.folder = folder;
  out.fit = reference::read_json_file(fit_file, {kLargestFit, kDepth});
  const fs::path plan_file = folder / "search" / "plan.yaml";
  try {
    const json schema = out.fit.is_object() ? out.fit.value("schema", json()) : json();
    if (schema != "palpate/fit/1")
      throw InputError(fit_file.string() + ": schema", 0, "palpate/fit/1", schema.dump());
    const json& choice = out.fit.at("choice");
    if (choice.is_null())
      throw InputError(fit_file.string() +
                       ": the fit found no model that meets its tolerance: there is "
                       "nothing whose borders could be looked for");
    out.choice.model.label = choice.at("label").get<std::string>();
    out.choice.model.method = choice.at("method").get<std::string>();
    if (out.choice.model.method == reference::kModalModel)
      throw InputError(
          fit_file.string() +
          ": the choice is reduced.modal, whose motion was verified on its own scene alone: what "
          "its modes leave of other motions no envelope measures");
    out.choice.model.set = choice.at("set");
    if (out.choice.model.set.contains("frozen"))
      out.choice.model.set["frozen"] =
          fs::absolute(folder / out.choice.model.set["frozen"].get<std::string>())
              .lexically_normal()
              .string();
    out.choice.simplifier = choice.at("simplify").get<std::string>();
    if (choice.at("tets_removed_ratio").is_number())
      out.choice.ratio = choice.at("tets_removed_ratio").get<double>();
    const json plan = read_yaml(plan_file).json();
    if (out.choice.simplifier != kNoSimplifier)
      out.simplifiers.simplifiers.push_back(find_simplifier(plan, out.choice.simplifier, folder, plan_file));
    out.levels = plan.at("reference").at("levels").get<int>();
    out.enough = plan.at("reference").at("enough").get<double>();
  } catch (const json::exception& error) {
    const std::string what = error.what();  // "[json.exception.out_of_range.403] key 'choice' not found"
    const std::size_t bracket = what.find("] ");
    throw InputError(folder.string() + ": not as palpate fit leaves it: " +
                     (bracket == std::string::npos ? what : what.substr(bracket + 2)));
  }
  out.scene = read_yaml(out.scene_file()).json();
  out.rest_scene = read_yaml(folder / "search" / "scene_0.yaml").json();
  return out;
}

}  // namespace palpate::experiments

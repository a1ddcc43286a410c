#include "experiments/fit/fit_output.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "core/base/atomic_file.h"
#include "core/base/number_text.h"
#include "core/mesh/io/medit.h"
#include "experiments/files/file_bytes.h"
#include "experiments/plan_reader/plan.h"
#include "experiments/records/record_file.h"
#include "experiments/scene_reader/scene_problem.h"
#include "experiments/scene_writer/placed_text.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

json finite_or_null(double value) {
  return std::isfinite(value) ? json(value) : json(nullptr);
}

json describe_point(const FitPoint& point) {
  const FitCandidate& own = point.candidate;
  json out{{"name", own.name()},
           {"label", own.model.label},
           {"method", own.model.method},
           {"set", own.model.set},
           {"simplify", own.simplifier},
           {"tets_removed_ratio", own.ratio ? json(*own.ratio) : json(nullptr)},
           {"vertices", point.vertices},
           {"tets", point.tets},
           {"error", point.error},
           {"reference_error", json::array()},
           {"worst_error", finite_or_null(point.worst_error())},
           {"cost_s", finite_or_null(point.cost())},
           {"cost_samples_s", point.cost_s},
           {"memory_bytes", point.memory_bytes}};
  for (const double own_error : point.own_error) out["reference_error"].push_back(finite_or_null(own_error));
  if (point.explicit_step_s) out["explicit_step_s"] = *point.explicit_step_s;
  return out;
}

/// What one change from `before` to the choice saves and costs.
json describe_saving(const std::string& what, const FitPoint& before, const FitPoint& after) {
  return {{"what", what},
          {"from", before.candidate.name()},
          {"cost_before_s", finite_or_null(before.cost())},
          {"cost_after_s", finite_or_null(after.cost())},
          {"error_before", before.error.empty() ? json(nullptr) : json(before.error.front())},
          {"error_after", after.error.empty() ? json(nullptr) : json(after.error.front())}};
}

/// Each step that makes the choice cheap, measured in the search with all else as in the choice.
json describe_savings(const FitResult& result) {
  json savings = json::array();
  const FitCandidate& own = result.choice->candidate;
  const FitPoint* now = find_point(result.searched, own.model.label, own.simplifier, own.ratio);
  if (now == nullptr) return savings;
  const auto add = [&](const std::string& what, const FitPoint* before) {
    if (before != nullptr && before != now && before->failure.empty())
      savings.push_back(describe_saving(what, *before, *now));
  };
  add("simplification", find_point(result.searched, own.model.label, kNoSimplifier, std::nullopt));
  const FitPoint* other = nullptr;
  for (const FitPoint& point : result.searched) {
    const FitCandidate& theirs = point.candidate;
    if (theirs.simplifier != own.simplifier || theirs.ratio != own.ratio || !point.failure.empty()) continue;
    if (theirs.model.label == own.model.label) continue;
    if (other == nullptr || point.error.front() < other->error.front()) other = &point;
  }
  add("model, against the most accurate on the same mesh", other);
  return savings;
}

json model_json(const FitModel& model) {
  const std::size_t dot = model.method.find('.');
  const std::string kind = model.method.substr(0, dot);
  json out = model.set;
  out[kind == "fem" ? "finite_elements" : kind] = model.method.substr(dot + 1);
  return out;
}

/// The scene with the chosen mesh and model. Regions are in metres: they stay where the whole mesh had them.
std::string fitted_scene(const FitResult& result, const Scene& placed) {
  json scene = placed_scene(result.scene, placed, "organ.mesh");
  scene["model"] = model_json(result.choice->candidate.model);
  return "# Made by palpate fit: " + result.choice->candidate.name() + "\n" + lines_of_scene(scene);
}

std::string percent_of(const json& share) {
  return share.is_number() ? three_digits(100.0 * share.get<double>()) + "%" : "-";
}

std::string seconds_of(const json& seconds) {
  return seconds.is_number() ? time_text(seconds.get<double>()) : "-";
}

const char* work_text(FitWork work) {
  if (work == FitWork::kSecond) return "a simulated second takes";
  return work == FitWork::kFurther ? "an answer to a new load takes" : "a first answer takes";
}

void add_choice(const FitResult& result, const json& fit, std::ostringstream& text) {
  const json& choice = fit.at("choice");
  text << "**" << choice.at("name").get<std::string>() << "** (" << choice.at("method").get<std::string>()
       << ", " << choice.at("tets") << " tetrahedra): " << work_text(result.work) << " "
       << seconds_of(choice.at("cost_s")) << ", error " << percent_of(choice.at("error").front())
       << " on the scene, at most " << percent_of(choice.at("worst_error")) << " on it and on " << kOtherLoads
       << " loads that the choice never saw, the reference's own error on top.\n";
  if (choice.contains("explicit_step_s"))
    text << "\nLongest stable step, undamped, predicted: " << seconds_of(choice.at("explicit_step_s"))
         << ".\n";
  text << "\n| what was saved | from | time before | time after | error before | error after "
          "|\n|---|---|---|---|---|---|\n";
  for (const json& saving : fit.at("savings"))
    text << "| " << saving.at("what").get<std::string>() << " | " << saving.at("from").get<std::string>()
         << " | " << seconds_of(saving.at("cost_before_s")) << " | " << seconds_of(saving.at("cost_after_s"))
         << " | " << percent_of(saving.at("error_before")) << " | " << percent_of(saving.at("error_after"))
         << " |\n";
}

void add_tried(const json& tried, std::ostringstream& text) {
  text << "\n| tried | tetrahedra | error | time | not taken, since |\n|---|---|---|---|---|\n";
  for (const json& point : tried)
    text << "| " << point.at("name").get<std::string>() << " | " << point.at("tets") << " | "
         << (point.at("error").empty() ? "-" : percent_of(point.at("error").front())) << " | "
         << seconds_of(point.at("cost_s")) << " | " << point.at("why_not").get<std::string>() << " |\n";
}

}  // namespace

json describe_fit(const FitResult& result) {
  const SceneRequirement& require = *result.scene.require;
  json fit{{"schema", "palpate/fit/1"},
           {"scene", fs::absolute(result.scene.file).string()},
           {"measure", require.measure},
           {"at_most", require.at_most},
           {"work", work_name(result.work)},
           {"budget_s", finite_or_null(budget_of(require))},
           {"needs", require.needs},
           {"complete", result.is_complete},
           {"wall_s", result.wall_s},
           {"dropped", result.dropped},
           {"choice", nullptr},
           {"nearest", nullptr},
           {"savings", json::array()},
           {"tried", json::array()},
           {"checked", json::array()}};
  if (require.memory_bytes) fit["memory_bytes"] = *require.memory_bytes;
  for (const auto& [key, points] :
       {std::pair("tried", &result.searched), std::pair("checked", &result.checked)}) {
    for (const FitPoint& point : *points) {
      json described = describe_point(point);
      described["why_not"] = why_not(point, require);
      fit[key].push_back(described);
    }
  }
  std::stable_sort(fit["tried"].begin(), fit["tried"].end(), [](const json& a, const json& b) {
    const auto cost = [](const json& point) {
      return point.at("cost_s").is_null() ? 1e300 : point.at("cost_s").get<double>();
    };
    return cost(a) < cost(b);
  });
  if (result.choice) {
    fit["choice"] = describe_point(*result.choice);
    fit["savings"] = describe_savings(result);
  } else if (result.nearest) {
    fit["nearest"] = describe_point(*result.nearest);
    fit["nearest"]["why_not"] = why_not(*result.nearest, require);
  }
  return fit;
}

std::string fit_text(const FitResult& result, const json& fit) {
  std::ostringstream text;
  const SceneRequirement& require = *result.scene.require;
  text << "# " << result.scene.name << "\n\nWanted: error of at most "
       << short_number(100.0 * require.at_most) << "% (" << require.measure << ")";
  if (std::isfinite(budget_of(require)))
    text << "; " << work_text(result.work) << " at most " << time_text(budget_of(require));
  text << ".\n\n";
  if (result.choice) {
    add_choice(result, fit, text);
  } else {
    text << "**Nothing that was tried does.**";
    if (result.nearest)
      text << " What comes closest is " << result.nearest->candidate.name() << ": "
           << why_not(*result.nearest, require) << ".";
    text << '\n';
  }
  if (!result.is_complete) text << "\nThe search was stopped before all was tried.\n";
  if (!result.dropped.empty()) {
    text << "\nNot tried:\n\n";
    for (const std::string& line : result.dropped) text << "- " << line << '\n';
  }
  add_tried(fit.at("tried"), text);
  return text.str();
}

void write_fit(const FitResult& result, const fs::path& folder) {
  const json fit = describe_fit(result);
  if (result.choice) {
    const Scene& scene = result.scene;
    const Scene placed = place_scene(scene, build_scene_mesh(scene.mesh).mesh);
    const fs::path mesh = result.run / "problems" / result.choice->mesh / "in.mesh";
    write_medit(folder / "organ.mesh", read_medit(mesh, ReadOrientation::kKeep).mesh);
    write_file_atomically(folder / "scene.yaml", fitted_scene(result, placed));
  }
  write_file_atomically(folder / "fit.md", fit_text(result, fit));
  write_file_atomically(folder / "fit.json", fit.dump(1) + "\n");
}

}  // namespace palpate::experiments

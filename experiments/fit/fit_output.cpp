#include "experiments/fit/fit_output.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "core/base/atomic_file.h"
#include "core/base/number_text.h"
#include "core/mesh/io/medit.h"
#include "experiments/files/plain_file.h"
#include "experiments/fit/fit_search.h"
#include "experiments/plan_reader/plan.h"
#include "experiments/records/record_file.h"
#include "experiments/scene_reader/scene_problem.h"
#include "experiments/scene_writer/placed_text.h"
#include "experiments/text/figure_text.h"
#include "reference/door/json_file.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;
using reference::number_or_null;

json describe_stepping(const SteppingTry& tried) {
  const FitStepping& own = tried.stepping;
  json out{{"label", own.label},
           {"integrator", own.integrator},
           {"precision", own.single_precision ? "single" : "double"},
           {"time_step_s", tried.step_s},
           {"motion_error", tried.error ? number_or_null(*tried.error) : json(nullptr)},
           {"cost_s", number_or_null(tried.cost())},
           {"cost_samples_s", tried.cost_s},
           {"why_not", tried.why_not}};
  if (!own.solver.is_null()) out["solver"] = own.solver;
  if (own.modes) out["modes"] = *own.modes;
  if (tried.memory_bytes > 0) out["memory_bytes"] = tried.memory_bytes;
  if (tried.setup_s) out["setup_s"] = *tried.setup_s;
  return out;
}

json describe_frozen_try(const FrozenTry& tried) {
  return {{"share_of_tolerance", tried.share},
          {"vertices", tried.vertices},
          {"tets", tried.tets},
          {"worst_error", tried.error ? number_or_null(*tried.error) : json(nullptr)},
          {"motion_error", tried.motion_error ? number_or_null(*tried.motion_error) : json(nullptr)},
          {"cost_before_s", tried.cost_before_s},
          {"cost_s", tried.cost_s},
          {"most_force_n", tried.most_force_n},
          {"why_not", tried.why_not}};
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
           {"worst_error", number_or_null(point.worst_error())},
           {"estimated_error", number_or_null(point.estimated_error())},
           {"cost_s", number_or_null(point.cost())},
           {"cost_samples_s", point.cost_s},
           {"memory_bytes", point.memory_bytes}};
  for (const double own_error : point.own_error) out["reference_error"].push_back(number_or_null(own_error));
  if (point.explicit_step_s) out["explicit_step_s"] = *point.explicit_step_s;
  if (point.answer_s) out["answer_s"] = *point.answer_s;
  if (point.stepping) out["stepping"] = describe_stepping(*point.stepping);
  for (const SteppingTry& tried : point.steppings) out["steppings"].push_back(describe_stepping(tried));
  return out;
}

/// What one change from `before` to the choice saves and costs.
json describe_saving(const std::string& what, const FitPoint& before, const FitPoint& after) {
  return {{"what", what},
          {"from", before.candidate.name()},
          {"cost_before_s", number_or_null(before.cost())},
          {"cost_after_s", number_or_null(after.cost())},
          {"error_before", before.error.empty() ? json(nullptr) : json(before.error.front())},
          {"error_after", after.error.empty() ? json(nullptr) : json(after.error.front())}};
}

/// What the choice's integrator saves against explicit steps in double precision, on the scene's own motion.
std::optional<json> describe_stepping_saving(const FitPoint& choice) {
  if (!choice.stepping) return std::nullopt;
  for (const SteppingTry& tried : choice.steppings) {
    const FitStepping& own = tried.stepping;
    if (own.integrator != kExplicitIntegrator || own.single_precision || tried.cost_s.empty()) continue;
    const SteppingTry* taken = choose_stepping(choice.steppings);
    if (taken == nullptr || own.label == taken->stepping.label) return std::nullopt;
    const auto error_of = [](const SteppingTry& of) { return of.error ? json(*of.error) : json(nullptr); };
    return json{{"what", "integrator and step, on the scene's motion: " + taken->stepping.label},
                {"from", own.label},
                {"cost_before_s", number_or_null(tried.cost())},
                {"cost_after_s", number_or_null(taken->cost())},
                {"error_before", error_of(tried)},
                {"error_after", error_of(*taken)}};
  }
  return std::nullopt;
}

/// The model, against the most accurate of the search on the same mesh; where the choice's share lies between
/// two of the search, on the mesh of the nearest.
std::optional<json> describe_model_saving(const FitResult& result) {
  const FitCandidate& own = result.choice->candidate;
  const FitPoint* mine = nullptr;
  const auto distance = [&](const FitPoint& point) {
    return std::abs(point.candidate.removed() - own.removed());
  };
  for (const FitPoint& point : result.searched) {
    const FitCandidate& theirs = point.candidate;
    const bool is_own = theirs.model.label == own.model.label && theirs.simplifier == own.simplifier;
    if (is_own && point.failure.empty() && (mine == nullptr || distance(point) < distance(*mine)))
      mine = &point;
  }
  const FitPoint* other = nullptr;
  for (const FitPoint& point : result.searched) {
    const FitCandidate& theirs = point.candidate;
    if (mine == nullptr || theirs.model.label == own.model.label || !point.failure.empty()) continue;
    if (theirs.simplifier != own.simplifier || theirs.ratio != mine->candidate.ratio) continue;
    if (other == nullptr || point.error.front() < other->error.front()) other = &point;
  }
  if (other == nullptr) return std::nullopt;
  const bool is_same_mesh = mine->candidate.ratio == own.ratio;
  const std::string where = "model, against the most accurate on the " +
                            (is_same_mesh ? std::string("same mesh") : "mesh of " + mine->candidate.name());
  return describe_saving(where, *other, *mine);
}

/// Each step that makes the choice cheap, measured in the search with all else as in the choice.
json describe_savings(const FitResult& result) {
  json savings = json::array();
  const FitCandidate& own = result.choice->candidate;
  const FitPoint* now = find_point(result.searched, own.model.label, own.simplifier, own.ratio);
  if (now == nullptr) now = &*result.choice;  // a share between two of the search
  const auto add = [&](const std::string& what, const FitPoint* before) {
    if (before != nullptr && before != now && before->failure.empty())
      savings.push_back(describe_saving(what, *before, *now));
  };
  for (const FrozenTry& tried : result.frozen) {
    if (tried.why_not.empty())
      savings.push_back({{"what", "held at rest: " + std::to_string(tried.tets) + " tetrahedra"},
                         {"from", "the same, whole"},
                         {"cost_before_s", tried.cost_before_s},
                         {"cost_after_s", tried.cost_s},
                         {"error_before", 0.0},
                         {"error_after", *tried.motion_error}});
  }
  add("simplification", find_point(result.searched, own.model.label, kNoSimplifier, std::nullopt));
  if (const auto saved = describe_model_saving(result)) savings.push_back(*saved);
  if (const auto saved = describe_stepping_saving(*result.choice)) savings.push_back(*saved);
  return savings;
}

/// Where the error is asked for: names of probes, or regions as the scene gives them; null for the whole
/// body.
json describe_places(const std::vector<ErrorPlace>& places) {
  json out;
  for (const ErrorPlace& place : places)
    out.push_back(place.probe ? place.probe->name : place.region.text + " at " + place.where);
  return out;
}

std::string places_text(const json& at) {
  if (at.is_null()) return "";
  std::string text;
  for (const json& place : at) text += (text.empty() ? " at " : ", ") + place.get<std::string>();
  return text;
}

std::string seconds_of(const json& seconds) {
  return seconds.is_number() ? time_text(seconds.get<double>()) : "-";
}

const char* work_text(FitWork work) {
  if (work == FitWork::kSecond) return "a simulated second takes";
  return work == FitWork::kFurther ? "an answer to a new load takes" : "a first answer takes";
}

/// On which loads the choice's error was looked at.
std::string loads_text(const json& fit) {
  const auto further = fit.at("confirming_loads").get<std::size_t>();
  std::string text = "it and on " + std::to_string(kOtherLoads) + " other loads that it was chosen by";
  if (further > 0)
    return text + ", and on " + std::to_string(further) + " more, the worst of " +
           fit.at("looked_at_loads").dump() + " that it was not chosen by";
  return text + " (no further ones were run)";
}

void add_steppings(const json& choice, std::ostringstream& text) {
  if (!choice.contains("steppings")) return;
  const json& chosen = choice.at("stepping");
  text << "\nStepped by `" << chosen.at("integrator").get<std::string>() << "` in "
       << chosen.at("precision").get<std::string>() << " precision, " << seconds_of(chosen.at("time_step_s"))
       << " a step, which leaves " << percent_of(chosen.at("motion_error"))
       << " of the scene's motion, what is held at rest with it (at most; in the error above).\n";
  if (chosen.contains("modes"))
    text << "\n"
         << chosen.at("modes") << " modes, held against the same finite elements stepped whole. They take "
         << seconds_of(chosen.value("setup_s", json()))
         << " to be found, which is in no time here; a simulated second has sixty displacements of all "
            "vertices.\n";
  text << "\n| tried on the motion | step | error | a simulated second | not taken, since |\n"
          "|---|---|---|---|---|\n";
  for (const json& tried : choice.at("steppings")) {
    const bool is_chosen = tried.at("label") == chosen.at("label");
    const std::string why = tried.at("why_not").get<std::string>();
    text << "| " << tried.at("label").get<std::string>() << " | " << seconds_of(tried.at("time_step_s"))
         << " | " << percent_of(tried.at("motion_error")) << " | " << seconds_of(tried.at("cost_s")) << " | "
         << (!why.empty() ? why
             : is_chosen  ? "taken"
                          : "it takes longer")
         << " |\n";
  }
}

void add_choice(const FitResult& result, const json& fit, std::ostringstream& text) {
  const json& choice = fit.at("choice");
  text << "**" << choice.at("name").get<std::string>() << "** (" << choice.at("method").get<std::string>()
       << ", " << choice.at("tets") << " tetrahedra): " << work_text(result.work) << " "
       << seconds_of(choice.at("cost_s")) << ", error " << percent_of(choice.at("error").front())
       << " on the scene, at most " << percent_of(choice.at("worst_error")) << " on " << loads_text(fit)
       << ", the reference's own error on top; on all loads like these estimated to be at most "
       << percent_of(choice.at("estimated_error")) << ".\n";
  if (choice.contains("explicit_step_s"))
    text << "\nLongest stable step, undamped, predicted: " << seconds_of(choice.at("explicit_step_s"))
         << ".\n";
  add_steppings(choice, text);
  for (const json& tried : fit.at("frozen")) {
    const std::string why = tried.at("why_not").get<std::string>();
    text << "\nHeld at rest: what moves by less than " << percent_of(tried.at("share_of_tolerance"))
         << " of the tolerance, " << tried.at("tets") << " tetrahedra; "
         << (why.empty() ? "taken. `simulate` wakes it (steps the whole model) where more than " +
                               short_number(tried.at("most_force_n").get<double>()) + " N act on it.\n"
                         : "not taken: " + why + ".\n");
  }
  text << "\n| what was saved | from | time before | time after | error before | error after "
          "|\n|---|---|---|---|---|---|\n";
  for (const json& saving : fit.at("savings"))
    text << "| " << saving.at("what").get<std::string>() << " | " << saving.at("from").get<std::string>()
         << " | " << seconds_of(saving.at("cost_before_s")) << " | " << seconds_of(saving.at("cost_after_s"))
         << " | " << percent_of(saving.at("error_before")) << " | " << percent_of(saving.at("error_after"))
         << " |\n";
}

/// `error` is the key of the error that is shown of each.
void add_points(const json& points, const std::string& heading, const char* error, std::ostringstream& text) {
  if (points.empty()) return;
  text << "\n| " << heading << " | time | not taken, since |\n|---|---|---|---|---|\n";
  for (const json& point : points) {
    const json& shown = point.at(error);
    text << "| " << point.at("name").get<std::string>() << " | " << point.at("tets") << " | "
         << (shown.empty()      ? "-"
             : shown.is_array() ? percent_of(shown.front())
                                : percent_of(shown))
         << " | " << seconds_of(point.at("cost_s")) << " | " << point.at("not_taken").get<std::string>()
         << " |\n";
  }
}

/// Why a point is not the choice: for what it leaves on the scene, for what it (or one like it) leaves on
/// other loads, or for its time. "taken": it is.
std::string why_not_the_choice(const FitPoint& point, const FitResult& result) {
  const SceneRequirement& require = *result.scene.require;
  const std::string name = point.candidate.name();
  if (result.choice && result.choice->candidate.name() == name) return "taken";
  std::string here = why_not_chosen(point, result.searched, require);
  if (!here.empty()) return here;
  for (const FitPoint& looked : result.checked) {
    if (looked.candidate.name() != name) continue;
    const std::string there = why_not_chosen(looked, result.checked, require);
    if (!there.empty()) return "on other loads: " + there;
  }
  if (result.choice && point.cost() >= result.choice->cost()) return "it is no cheaper";
  std::string like = why_not_chosen(point, result.checked, require);
  return like.empty() ? "it was not looked at on other loads" : like;
}

/// Why what comes closest is no choice.
std::string why_not_taken(const FitPoint& nearest, const SceneRequirement& require) {
  const std::string why = why_not(nearest, require);
  return why.empty()
             ? "it meets all of it on the scene itself, and the time was up before other loads could tell"
             : why;
}

}  // namespace

json describe_fit(const FitResult& result) {
  const SceneRequirement& require = *result.scene.require;
  json fit{{"schema", "palpate/fit/1"},
           {"scene", fs::absolute(result.scene.file).string()},
           {"measure", require.measure},
           {"at_most", require.at_most},
           {"at", describe_places(require.places)},
           {"work", work_name(result.work)},
           {"budget_s", number_or_null(budget_of(require))},
           {"needs", require.needs},
           {"complete", result.is_complete},
           {"wall_s", result.wall_s},
           {"dropped", result.dropped},
           {"choice", nullptr},
           {"nearest", nullptr},
           {"confirming_loads", 0},
           {"looked_at_loads", 0},
           {"savings", json::array()},
           {"tried", json::array()},
           {"checked", json::array()},
           {"frozen", json::array()}};
  for (const FrozenTry& tried : result.frozen) fit["frozen"].push_back(describe_frozen_try(tried));
  if (require.memory_bytes) fit["memory_bytes"] = *require.memory_bytes;
  for (const auto& [key, points] :
       {std::pair("tried", &result.searched), std::pair("checked", &result.checked)}) {
    for (const FitPoint& point : *points) {
      json described = describe_point(point);
      described["why_not"] = why_not_chosen(point, *points, require);
      described["not_taken"] = why_not_the_choice(point, result);
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
    fit["confirming_loads"] = result.choice->confirmed_on.size();
    fit["looked_at_loads"] = std::max<std::size_t>(result.choice->looked_at, fit.at("confirming_loads"));
    fit["savings"] = describe_savings(result);
  } else if (result.nearest) {
    fit["nearest"] = describe_point(*result.nearest);
    fit["nearest"]["why_not"] = why_not_taken(*result.nearest, require);
  }
  return fit;
}

std::string fit_text(const FitResult& result, const json& fit) {
  std::ostringstream text;
  const SceneRequirement& require = *result.scene.require;
  text << "# " << result.scene.name << "\n\nWanted: error of at most "
       << short_number(100.0 * require.at_most) << "% (" << require.measure << ")"
       << places_text(fit.at("at"));
  if (std::isfinite(budget_of(require)))
    text << "; " << work_text(result.work) << " at most " << time_text(budget_of(require));
  text << ".\n\n";
  if (result.choice) {
    add_choice(result, fit, text);
  } else {
    text << "**Nothing that was tried does.**";
    if (result.nearest)
      text << " What comes closest is " << result.nearest->candidate.name() << ": "
           << fit.at("nearest").at("why_not").get<std::string>() << ".";
    text << '\n';
  }
  if (!result.is_complete) text << "\nThe search was stopped before all was tried.\n";
  if (!result.dropped.empty()) {
    text << "\nNot tried:\n\n";
    for (const std::string& line : result.dropped) text << "- " << line << '\n';
  }
  add_points(fit.at("checked"), "looked at on other loads, too | tetrahedra | worst error", "worst_error",
             text);
  add_points(fit.at("tried"), "tried | tetrahedra | error on the scene", "error", text);
  return text.str();
}

void write_fit(const FitResult& result, const fs::path& folder) {
  const json fit = describe_fit(result);
  if (result.choice) {
    const Scene& scene = result.scene;
    const Scene placed = place_scene(scene, build_scene_mesh(scene.mesh).mesh);
    const fs::path mesh = result.run / "problems" / result.choice->mesh / "in.mesh";
    write_medit(folder / "organ.mesh", read_medit(mesh, ReadOrientation::kKeep).mesh);
    const fs::path whole = whole_mesh_of(result.choice->candidate, result.run);
    json fitted = build_fitted_scene(placed, result.choice->candidate.model, whole);
    if (!whole.empty() && placed.whole == nullptr) {
      write_medit(folder / "whole.mesh", read_medit(whole, ReadOrientation::kKeep).mesh);
      fitted["mesh"]["regions_from"] = "whole.mesh";
    }
    if (const auto& chosen = result.choice->stepping)
      chosen->stepping.apply(chosen->is_auto ? json("auto") : json(chosen->step_s), fitted);
    if (!result.frozen_file.empty())
      write_file_atomically(folder / "frozen.json",
                            reference::read_json_file(result.frozen_file).dump() + "\n");
    write_file_atomically(folder / "scene.yaml", "# Made by palpate fit: " + result.choice->candidate.name() +
                                                     "\n" + lines_of_scene(fitted));
  }
  write_file_atomically(folder / "fit.md", fit_text(result, fit));
  write_file_atomically(folder / "fit.json", fit.dump(1) + "\n");
}

}  // namespace palpate::experiments

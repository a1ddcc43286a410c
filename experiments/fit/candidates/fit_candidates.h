// What a fit tries: simplifiers with shares of tetrahedra, and models with what each can do.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "experiments/grading/grade_wish.h"
#include "experiments/registry/registry.h"
#include "experiments/scene_reader/scene.h"
#include "experiments/trials/fit_stepping.h"

namespace palpate::experiments {

/// The kind of work that a fit makes cheap.
enum class FitWork {
  kFirst,    ///< a displacement with all that it takes
  kFurther,  ///< that of another load, once all is prepared
  kSecond    ///< a simulated second of explicit steps
};

/// "first", "further" or "second".
const char* work_name(FitWork work);

/// What a scene asks to be cheap: by the budget that it gives; without one, motion where it moves, else a
/// first answer.
FitWork choose_work(const Scene& scene);

/// The budget of that work in s; infinite without one.
double budget_of(const SceneRequirement& require);

struct FitSimplifier {
  std::string label;
  std::string method;
  std::vector<double> ratios;                     ///< shares of the tetrahedra to remove
  std::optional<GradeWish> grade;                 ///< how its mesh is graded by the scene
  nlohmann::json set = nlohmann::json::object();  ///< options; of a graded one the file of its sizes too
  /// How far its skin may stray: a share of the diagonal of the body's box. None: as `set` says.
  std::optional<double> skin_within{};
};

struct FitModel {
  std::string label;
  std::string method;
  nlohmann::json set;                                     ///< options
  std::map<std::string, std::vector<std::string>> works;  ///< work -> what may change while it is done

  /// What of `needs` it cannot do at this work, or the work itself; empty if it can do all.
  std::string cannot(FitWork work, const std::vector<std::string>& needs) const;
};

struct FitCandidates {
  std::vector<FitSimplifier> simplifiers;
  std::vector<FitModel> models;
  std::vector<FitStepping> steppings;  ///< of scenes that move; none: explicit steps as they are
};

/// Reads palpate/candidates/1. Throws: InputError with file and line, also for an unknown method (with the
/// nearest) or option.
FitCandidates read_candidates(const std::filesystem::path& path, const Registry& registry);

/// Gives each simplifier with `skin_within` its bound on a body with that diagonal, in metres (its option
/// `max_surface_error_m`).
void set_skin_bounds(FitCandidates& candidates, double diagonal_m);

/// Takes out the steppings that cannot keep possible what a scene needs; `dropped` gets their labels with
/// the reason (of modes, whose model says it itself, nothing).
void drop_steppings(std::vector<FitStepping>& steppings, const std::vector<std::string>& needs,
                    std::vector<std::string>& dropped);

/// experiments/fit/candidates.yaml.
std::filesystem::path candidates_path();

}  // namespace palpate::experiments

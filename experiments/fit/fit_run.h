// palpate fit: the cheapest model that meets a scene's tolerance within its budget, searched for and then
// verified.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "experiments/fit/candidates/fit_points.h"
#include "experiments/fit/fit_options.h"
#include "experiments/text/terminal.h"
#include "experiments/trials/frozen_choice.h"

namespace palpate::experiments {

/// What a fit found.
struct FitResult {
  Scene scene;
  FitWork work = FitWork::kFirst;
  std::vector<std::string> dropped;     ///< models that cannot do what is needed
  std::vector<FitPoint> searched;       ///< every candidate on the scene as it is
  std::vector<FitPoint> checked;        ///< finalists, on the scene and on other loads
  std::optional<FitPoint> choice;       ///< verified; nothing if nothing does
  std::vector<FrozenTry> frozen;        ///< parts of the choice that were held at rest
  std::filesystem::path frozen_file{};  ///< of the one that is taken; empty: none
  std::optional<FitPoint> nearest;      ///< where there is no choice: what comes closest
  std::filesystem::path run;            ///< that has the choice's mesh, or the nearest's
  bool is_complete = true;              ///< false: stopped before all was tried
  bool is_interrupted = false;          ///< by the user
  double wall_s = 0.0;
};

/// Searches all candidates on the scene at rest, takes the cheapest that meet the tolerance with the
/// reference's own error on top, and runs those again with more repeats on the scene and on kOtherLoads other
/// loads, until the cheapest of them meets it everywhere. Of a scene at rest shares between the candidates'
/// are looked at too, as long as they may be cheaper. What is chosen is looked at under kFurtherLoads more
/// loads and run on the kConfirmingLoads worst of them: if it does not hold there, or what is estimated of
/// all loads like these does not, the next is looked for.
///
/// Throws: InputError for a scene without "require", a folder that holds something, and as run_plan.
FitResult run_fit(const FitOptions& options, const Registry& registry, Progress& progress);

}  // namespace palpate::experiments

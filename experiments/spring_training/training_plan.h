// What springs are trained on, as data (palpate/training/1): loads, clamps, and which of them are looked at.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/mesh/boundary_problem.h"
#include "core/springs/identification/identify_options.h"
#include "experiments/scene_reader/scene.h"

namespace palpate::experiments {

/// Clamps or loads that act together, by name.
struct NamedClamps {
  std::string name;
  std::vector<SceneClamp> clamps;
};
struct NamedLoads {
  std::string name;
  std::vector<SceneLoad> loads;
};

/// A clamp with a load, by their places in the plan.
struct TrainingPair {
  std::size_t clamp = 0;
  std::size_t load = 0;
  bool operator==(const TrainingPair&) const = default;
};

/// The cases of one set: the products of clamps and loads that the plan lists.
struct TrainingSplit {
  std::string name;  ///< "train", "validate", "test_loads", "test_clamps"
  std::vector<TrainingPair> cases;
};

/// What carries the dilatation beside the springs; both have trained moduli.
enum class TrainedVolume { kNone, kTet, kNodeAverage };

struct TrainingPlan {
  std::filesystem::path file;
  SceneMesh mesh;
  Material material;
  springs::SpringMethod start = springs::SpringMethod::kIsotropyPatch;
  bool face_opposite = false;
  bool calibrate = false;  ///< the start times one factor, from the moduli that it has on its own mesh
  TrainedVolume volume = TrainedVolume::kNone;
  int refine = 1;                ///< of the quadratic elements that make the fields to learn from
  std::vector<double> ridges;    ///< the validation set chooses among them
  std::size_t iterations = 150;  ///< of each fit
  std::vector<NamedClamps> clamps;
  std::vector<NamedLoads> loads;
  TrainingSplit train{"train", {}};
  TrainingSplit validate{"validate", {}};
  TrainingSplit test_loads{"test_loads", {}};    ///< loads that no choice looks at, on clamps of `train`
  TrainingSplit test_clamps{"test_clamps", {}};  ///< clamps that no choice looks at
};

/// Reads and checks a training plan.
///
/// Throws: InputError "file:line: ..." as read_scene does, and for a test set that is not apart: a load of
///         test_loads or a clamp of test_clamps that `train` or `validate` has too; an unknown name (with the
///         nearest), a name twice, an empty set; a Poisson ratio that the model cannot represent (without a
///         volume model 0.25 alone; with one, 0.25 to 0.5).
TrainingPlan read_training_plan(const std::filesystem::path& path);

}  // namespace palpate::experiments

// The plans of a fit: all candidates on the scene as it is, and its finalists on loads that the choice never
// saw.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "experiments/fit/candidates/fit_candidates.h"

namespace palpate::experiments {

/// A model on a mesh, as a fit tries it.
struct FitCandidate {
  FitModel model;
  std::string simplifier;  ///< label; "none" for the mesh as it is
  std::optional<double> ratio;

  /// "edge_node, refined -80%".
  std::string name() const;

  /// The share of tetrahedra that is removed; 0 for the mesh as it is.
  double removed() const { return ratio.value_or(0.0); }

  /// Whether it is a share by that simplifier; the mesh as it is belongs to each.
  bool is_share_of(const std::string& label) const { return !ratio || simplifier == label; }
};

/// All of a list that can do what the scene needs; `dropped` gets the others' labels with the reason.
std::vector<FitCandidate> list_candidates(const FitCandidates& candidates, FitWork work,
                                          const SceneRequirement& require, std::vector<std::string>& dropped);

/// The scene as a static one for a contest of displacements: every load at its greatest share, all at once,
/// without model and requirement (but where its error is asked for), its mesh's file by its whole path.
/// Throws: InputError as read_yaml.
nlohmann::json static_scene(const Scene& scene);

/// Where in the range that a fit is meant for another load lies.
enum class LoadRange : std::uint8_t {
  kBorder,  ///< where loads differ most from the scene's own; numbers lie spread evenly around it
  kWhole    ///< anywhere, at random: the number is the seed
};

/// Other loads on the same supports: each one's direction turned by up to 30 degrees, its size times 0.7 to
/// 1.3, and its place moved by up to half its radius (a direction on the surface, by up to 15 degrees);
/// half-spaces and boxes stay, and all places without `moves_places`.
nlohmann::json perturbed_scene(const nlohmann::json& scene, std::uint64_t number,
                               LoadRange range = LoadRange::kBorder, bool moves_places = true);

/// The scene with the model and `organ.mesh` (metres) beside it. Regions are in metres: they stay where the
/// scene's own mesh had them. `placed` is the scene on that (place_scene). `whole` is the whole mesh's file,
/// in metres, where organ.mesh is a simplified one, or empty.
nlohmann::json build_fitted_scene(const Scene& placed, const FitModel& model,
                                  const std::filesystem::path& whole);

/// The file of the whole mesh, in metres, in the run of a fit; empty for a candidate on that mesh itself.
std::filesystem::path whole_mesh_of(const FitCandidate& candidate, const std::filesystem::path& run);

/// One plan of a fit and where it goes.
struct FitPlan {
  std::filesystem::path folder;        ///< the plan, its scenes, and "run"
  std::vector<nlohmann::json> scenes;  ///< as static_scene; named scene_0, scene_1, ...
  std::vector<FitCandidate> candidates;
  FitWork work = FitWork::kFirst;
  int levels = 3;       ///< of the reference
  double enough = 0.0;  ///< no further level once its own error is this small
  int repeats = 1;
  bool measures_answers = false;  ///< of kSecond: a back-substitution too, for implicit steps
};

/// Writes the plan and its scenes (JSON, which is YAML) below its folder; returns the plan's file.
/// Throws: InputError if it cannot be written.
std::filesystem::path write_fit_plan(const FitPlan& plan, const FitCandidates& candidates);

/// The label of a candidate in its plan.
std::string plan_label(const FitCandidate& candidate);

}  // namespace palpate::experiments

// A run's folder: what is where, and who may write to it.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "experiments/plan_reader/plan.h"
#include "experiments/records/record_file.h"

namespace palpate::experiments {

/// Paths in a run folder.
struct RunPaths {
  std::filesystem::path folder;

  std::filesystem::path plan() const { return folder / "plan.yaml"; }
  std::filesystem::path provenance() const { return folder / "provenance.json"; }
  std::filesystem::path records() const { return folder / "records.jsonl"; }
  /// Records of failed repeats that were run anew (set_aside).
  std::filesystem::path retried() const { return folder / "retried.jsonl"; }
  /// Parts of the run that are run side by side, until they are taken in.
  std::filesystem::path parts() const { return folder / ".parts"; }
  std::filesystem::path scratch() const { return folder / ".scratch"; }

  /// The output mesh of a case ("meshes/kidney/hierarchical_87.mesh"), or the input
  /// ("meshes/kidney/input.mesh").
  std::filesystem::path mesh(const std::string& case_id) const {
    return folder / "meshes" / (case_id + ".mesh");
  }

  /// The displacement of a case of the contest deform.
  std::filesystem::path displacement(const std::string& case_id) const {
    return folder / "displacements" / (case_id + ".csv");
  }

  /// The field that a problem of the contest deform is judged by.
  std::filesystem::path reference(const std::string& problem_id) const {
    return folder / "references" / (problem_id + ".csv");
  }

  /// The history of a case of the contest motion.
  std::filesystem::path history(const std::string& case_id) const {
    return folder / "histories" / (case_id + ".csv");
  }

  /// What a case of the contests engine and stability leaves of its motion.
  std::filesystem::path motion(const std::string& case_id) const {
    return folder / "motions" / (case_id + ".json");
  }

  /// The folder of a problem of the contests deform, motion and stability: in.mesh (metres) and problem.json.
  std::filesystem::path problem(const std::string& id) const { return folder / "problems" / id; }
};

/// A run folder that this process holds.
class RunFolder {
 public:
  /// Creates the folder, or takes up an existing one when `resume` is set.
  /// Throws: InputError if it cannot be written, is in use, holds something else, or holds a run and `resume`
  ///         is not set.
  RunFolder(const std::filesystem::path& folder, bool resume);
  ~RunFolder();
  RunFolder(const RunFolder&) = delete;
  RunFolder& operator=(const RunFolder&) = delete;

  const RunPaths& paths() const { return paths_; }

  /// The provenance that an earlier start left; nothing if there is none, or if this one starts anew.
  /// Throws: InputError if there are records and no provenance: whose they are, nobody can tell.
  std::optional<nlohmann::json> earlier_provenance() const;

  /// An empty scratch folder that no other process knows of: what a killed run left and still writes does not
  /// come in. The one before is removed.
  std::filesystem::path fresh_scratch() const;

 private:
  RunPaths paths_;
  bool resume_;
  std::optional<FolderLock> lock_;
};

/// Where a plan's runs go by default: <plan> in results_root().
std::filesystem::path results_folder(const std::string& plan_name);

/// A name for a new run below `parent` that no folder has yet: UTC time stamp and commit.
std::filesystem::path new_run_folder(const std::filesystem::path& parent);

/// The run in `folder` itself if it holds one, otherwise its newest sub-folder that does.
/// Throws: InputError if there is none.
std::filesystem::path find_run(const std::filesystem::path& folder);

}  // namespace palpate::experiments

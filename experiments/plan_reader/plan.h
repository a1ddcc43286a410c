// A plan: one question, as data. runner/read_plan reads one.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "experiments/grading/grade_wish.h"
#include "experiments/meshes/mesh_source.h"
#include "experiments/plan_reader/sweep.h"
#include "experiments/registry/method_options.h"
#include "experiments/scene_reader/scene.h"

namespace palpate::experiments {

/// A mesh of a plan: a shape that is made, or a file.
struct PlanMesh {
  std::string name;
  std::optional<ShapeRequest> shape;
  std::filesystem::path file;     ///< when there is no shape; resolved against the plan's folder
  std::string where;              ///< "plan.yaml:3", for messages
  std::vector<std::string> tags;  ///< words by which a run may choose its cases
};

/// A scene of a plan, read and checked.
struct PlanScene {
  std::string name;
  Scene scene;
  std::vector<std::string> tags;  ///< as those of a mesh
};

/// The reference that a contest of displacements is judged by: a method with quadratic elements and an
/// integer option "refine", solved on the mesh (refine 0) and on its uniform refinements.
struct PlanReference {
  std::string method;
  std::map<std::string, GivenOption> set;
  int levels = 2;                ///< refine = 0 ... levels - 1
  std::optional<double> enough;  ///< no further level once the estimated relative L2 error is this small
  std::optional<double> stated_order;  ///< of convergence, for two levels; three observe their own
};

/// One contestant of a plan.
struct PlanContestant {
  std::string method;
  std::string label;
  std::optional<Stop> stop;
  std::map<std::string, GivenOption> set;
  std::filesystem::path train;      ///< training plan whose springs it takes; empty: none
  std::vector<std::string> keep;    ///< regions whose tets are left alone, as parse_kept_region reads them
  std::string keep_where;           ///< "plan.yaml:7", for messages
  std::vector<std::int64_t> seeds;  ///< one case each, as the option seed
  std::vector<std::string> scenes;  ///< contest engine: those that it runs on; empty: all
  /// Contest deform: values of the sweep at which alone it runs, by axis ("vertices", "simplify", ...).
  std::map<std::string, std::vector<nlohmann::json>> at;
  std::vector<std::string> tags;   ///< words by which a run may choose its cases
  std::optional<GradeWish> grade;  ///< a simplifier of the contest deform: sizes by the scene
  bool required = true;            ///< false: its outcome does not decide the exit code
  std::optional<bool> timed;       ///< in place of the plan's
  /// Contest motion: options that, set over its own, give the motion that its solver would come to if it left
  /// nothing. Empty: it is not held against that.
  std::map<std::string, GivenOption> own_limit;
};

/// How the cases are run.
struct RunSettings {
  int repeats = 1;
  int seed_repeats = 0;  ///< of a case that is one of several seeds; 0: as many as of any other
  int warmup = 0;
  /// Repeats go on until the 95% interval of a case's median kernel time is at most this wide, as a share of
  /// the median ...
  std::optional<double> until_width;
  int most_repeats = 0;  ///< ... or there are so many of them
  /// Cases that cannot be on the plan's frontier any more get no more repeats: looked at after so many of
  /// each, after twice as many, ... (rounds/halving.h). 0: all get all.
  int halving_from = 0;
  std::int64_t order_seed = 1;  ///< of the random order of the cases in each round
  int threads = 1;
  int mpi_ranks = 1;  ///< of each method that can run under mpirun and whose entry does not say how many
  bool timed = true;  ///< false: records have no times, and cases may run side by side
  double timeout_s = 300.0;
  std::uint64_t memory_mib = 4096;
  double judge_timeout_s = 600.0;         ///< of the judge, for each answer
  std::uint64_t judge_memory_mib = 8192;  ///< of the judge, beyond what the runner has
};

/// Bounds that a measure has to keep.
struct AcceptBound {
  std::string measure;
  std::optional<double> min;
  std::optional<double> max;
};

/// What one contest alone reads from its plan.
struct ContestPart {
  virtual ~ContestPart() = default;
};

struct Plan {
  std::filesystem::path file;
  std::string name;  ///< the file's name without its ending
  std::string question;
  std::string contest;  ///< one of runner/contest_table
  std::vector<std::string>
      subjects;                   ///< the names of what its cases are about: its meshes, scenes, known cases
  std::vector<PlanMesh> meshes;   ///< of contests that start from meshes
  std::vector<PlanScene> scenes;  ///< of contests that start from scenes
  std::optional<PlanReference> reference;   ///< of contests that are judged by a solution
  std::vector<PlanContestant> simplifiers;  ///< of the contests' inputs; may be empty
  std::vector<PlanContestant> contestants;
  std::vector<SweepAxis> sweep;
  RunSettings run;
  std::vector<std::string> measure;
  std::vector<std::string> compared;  ///< measures whose better side the report needs
  std::vector<AcceptBound> accept;
  /// Of the key "frontier": the family of each label, of contestants or of simplifiers.
  std::map<std::string, std::string> families;
  bool families_of_simplifiers = false;
  std::vector<std::string> charts;          ///< empty: the report's choice
  std::vector<std::string> notes;           ///< worth saying, no error: contestants that are unavailable here
  std::shared_ptr<const ContestPart> part;  ///< may be null
};

/// What the plan's contest alone read. Throws: std::bad_cast if it is not a `Part`.
template <typename Part>
const Part& part_of(const Plan& plan) {
  return dynamic_cast<const Part&>(*plan.part);
}

/// The simplifier that leaves the mesh as it is: its method is empty.
inline constexpr const char* kNoSimplifier = "none";

}  // namespace palpate::experiments

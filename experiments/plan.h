// A plan: one question, as data. Reading one checks everything that can be checked without running anything.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "experiments/contestant.h"
#include "experiments/mesh_source.h"
#include "experiments/scene.h"

namespace palpate::experiments {

/// A mesh of a plan: a shape that is made, or a file.
struct PlanMesh {
  std::string name;
  std::optional<ShapeRequest> shape;
  std::filesystem::path file;  ///< when there is no shape; resolved against the plan's folder
};

/// A scene of a plan, read and checked.
struct PlanScene {
  std::string name;
  Scene scene;
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

/// When a simplifier stops.
enum class StopKind { kFusions, kTets, kRatio, kLimit, kTetsOf };

struct Stop {
  StopKind kind = StopKind::kLimit;
  double value = 0.0;  ///< a count, or the share of tets to remove
  std::string of;      ///< kTetsOf: the label whose tets are matched
};

/// A stop's name in plans, requests and records: "fusions", "tets", "ratio", "limit", "tets_of".
const char* stop_name(StopKind kind);

/// The stop as a request and a record say it: {"tets": 100}, {"limit": true}. kTetsOf is not among them.
nlohmann::json stop_request(const Stop& stop);

/// One contestant of a plan.
struct PlanContestant {
  std::string method;
  std::string label;
  std::optional<Stop> stop;
  std::map<std::string, GivenOption> set;
  std::filesystem::path train;      ///< training plan whose springs it takes; empty: none
  std::vector<std::string> keep;    ///< regions whose tets are left alone, as parse_keep reads them
  std::vector<std::int64_t> seeds;  ///< one case each, as the option seed
  std::vector<std::string> scenes;  ///< contest engine: those that it runs on; empty: all
  bool required = true;             ///< false: its outcome does not decide the exit code
};

/// One dimension of the sweep.
struct SweepAxis {
  std::string name;  ///< a stop ("tets_removed_ratio", "fusions", "tets"), "poisson_ratio", "vertices" or
                     ///< "option.NAME"
  std::vector<nlohmann::json> values;
  std::vector<GivenOption> texts;  ///< the same as written, for options

  bool is_option() const { return name.rfind("option.", 0) == 0; }
  bool is_problem() const { return name == "poisson_ratio" || name == "vertices"; }
  bool is_stop() const { return !is_option() && !is_problem(); }
  std::string option() const { return name.substr(7); }
  StopKind stop_kind() const;
};

/// How the cases are run.
struct RunSettings {
  int repeats = 1;
  int warmup = 0;
  int threads = 1;
  double timeout_s = 300.0;
  std::uint64_t memory_mib = 4096;
};

/// Bounds that a measure has to keep.
struct AcceptBound {
  std::string measure;
  std::optional<double> min;
  std::optional<double> max;
};

/// What some contestants are to reach on a case with a known answer, on its finest mesh.
struct KnownCaseExpectation {
  std::vector<std::string> labels;
  std::vector<AcceptBound> bounds;
};

/// A case with a known answer, of reference/closed_form.
struct PlanKnownCase {
  std::string name;
  std::vector<int> cells;  ///< one mesh each, rising
  std::vector<KnownCaseExpectation> expect;
};

/// Settings of the contest stability that are swept together.
struct PlanExtreme {
  std::string name;
  std::vector<std::size_t> meshes;        ///< indices into Plan::meshes
  std::vector<std::size_t> contestants;   ///< and into Plan::contestants
  std::optional<std::size_t> simplifier;  ///< and into Plan::simplifiers
  std::map<std::string, GivenOption> set;
  std::vector<SweepAxis> sweep;  ///< of options, by their plain names
};

/// A published claim, and what would decide it.
struct Claim {
  std::string text;
  std::string source;
  std::string measure;
  std::string better;
  std::string than;
  std::string spread;  ///< label with seeds whose scatter is shown; may be empty
  std::optional<double> published_better;
  std::optional<double> published_than;
};

/// One label held against the best of others, figure by figure, on every mesh and at every point of the
/// sweep.
struct Comparison {
  std::string of;
  std::vector<std::string> against_best_of;
  std::vector<std::string> measures;        ///< each has a better side
  std::string time_against;                 ///< label whose time is divided by that of `of`; empty: none
  std::optional<double> time_factor;        ///< how large that ratio is to be; nothing: it is only shown
  std::optional<double> input_up_to_ratio;  ///< up to this share of removed tets the input is a peer too
};

struct Plan {
  std::filesystem::path file;
  std::string name;  ///< the file's name without its ending
  std::string question;
  std::string contest;            ///< "simplify", "deform", "motion", "verify", "engine" or "stability"
  std::vector<PlanMesh> meshes;   ///< simplify and stability
  std::vector<PlanScene> scenes;  ///< deform, motion and engine
  std::vector<PlanKnownCase> known_cases;  ///< verify
  std::vector<PlanExtreme> extremes;       ///< stability
  std::optional<PlanReference> reference;  ///< deform and motion; engine, of the tool's force: may be missing
  std::vector<PlanContestant> simplifiers;  ///< deform: each is crossed with each contestant; stability: for
                                            ///< the extremes that name them; may be empty
  std::vector<PlanContestant> contestants;
  std::vector<SweepAxis> sweep;
  std::vector<std::string> region;  ///< whose tets are counted in every output; keeps nothing by itself
  RunSettings run;
  std::vector<std::string> measure;
  std::vector<AcceptBound> accept;
  std::optional<Claim> claim;
  std::optional<double> equal_count;  ///< answers are ranked within this share of the count asked for
  std::vector<Comparison> comparisons;
  std::vector<std::string> charts;  ///< empty: the report's choice
  std::vector<std::string> notes;   ///< worth saying, no error: contestants that are unavailable here
};

/// The simplifier that leaves the mesh as it is: its method is empty.
inline constexpr const char* kNoSimplifier = "none";

/// The names of what a plan's cases are about: its meshes, or its scenes.
std::vector<std::string> subject_names(const Plan& plan);

/// Reads and checks a plan (palpate/plan/1).
///
/// Throws: InputError "file:line: ..." for unknown keys and names (with the nearest), wrong types, impossible
///         stops, labels twice, circles of tets_of, missing mesh files.
Plan read_plan(const std::filesystem::path& path, const Registry& registry);

}  // namespace palpate::experiments

// What a plan of the contest simplify adds: meshes, a region, a claim, comparisons.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/plan_reader/plan.h"
#include "experiments/text/yaml_value.h"

namespace palpate::experiments {

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

/// What the contest simplify alone reads.
struct SimplifyPart : ContestPart {
  std::vector<std::string> region;  ///< whose tets are counted in every output; keeps nothing by itself
  std::optional<Claim> claim;
  std::optional<double> feature_deg;  ///< sharper edges of the input are looked for in every output
  std::optional<double> equal_count;  ///< answers are ranked within this share of the count asked for
  std::vector<Comparison> comparisons;
};

/// Reads it: see ContestKind::read. Throws: InputError with file and line, also where a label is compared
/// with itself, a measure has no better side or is of sharp edges without "feature_deg", a time factor is
/// given without a label to time against, or times are compared in a plan with fewer than 9 repeats or
/// without a warm-up.
void read_simplify_plan(const YamlFields& fields, Plan& plan, const Registry& registry);

}  // namespace palpate::experiments

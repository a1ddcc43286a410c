// A plan as parts that an existing workflow engine runs as jobs.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "experiments/plan_reader/case_list.h"
#include "experiments/plan_reader/plan.h"
#include "experiments/registry/registry.h"

namespace palpate::experiments {

/// What earlier records say of the cost of each repeat of a case, or of an input: all solutions of a
/// reference.
struct CaseCost {
  double seconds = 0.0;     ///< wall clock, median
  double memory_mib = 0.0;  ///< resident, at most
};

/// The costs that the records of `runs` hold, by case or input; those without a time are left out.
/// Throws: InputError if a folder holds no run.
std::map<std::string, CaseCost> read_costs(const std::vector<std::filesystem::path>& runs);

/// A job: some cases, and what they ask of a node.
struct CampaignPart {
  std::string name;  ///< "0007"
  std::vector<std::string> cases;
  double seconds = 0.0;        ///< expected
  std::size_t minutes = 0;     ///< asked for
  std::size_t memory_mib = 0;  ///< asked for
  bool is_timed = false;       ///< it has a case with times, and is to have the node for itself
};

/// What parts are made by.
struct CampaignSettings {
  double job_seconds = 600.0;     ///< short cases are put together until a part takes about so long
  double unknown_seconds = 10.0;  ///< of a repeat that no record tells of
};

/// Splits a plan. Cases that need each other lie in one part; timed ones of one mesh or scene too, so that
/// what is compared has run on one node, in turns. A part asks for the memory of the plan's bound, or a
/// quarter more than was measured, on top of what this program takes itself; for four times its expected time
/// and ten minutes, but never for more than the plan's own time-outs add up to.
std::vector<CampaignPart> split_campaign(const Plan& plan, const std::vector<Case>& cases,
                                         const std::map<std::string, CaseCost>& costs,
                                         const CampaignSettings& settings);

/// What a job asks of a node.
struct JobRequest {
  std::size_t minutes = 0;
  std::size_t memory_mib = 0;
};

/// The jobs before and behind the parts.
struct CampaignEnds {
  JobRequest prepare;  ///< meshes, references, trained springs
  JobRequest gather;   ///< takes the parts, runs what nobody ran, and makes the report
};

/// What the ends ask for. Preparing asks for ten minutes and one a mesh or scene, and where there are
/// references or training, for four times what earlier records tell of all of them, for a day where they tell
/// nothing. Gathering makes the inputs anew where nodes share no cache, may have to run a part that was lost,
/// and takes 0.7 s and a MiB for each thousand of records (docs/scaling.md).
CampaignEnds request_ends(const Plan& plan, const std::vector<Case>& cases,
                          const std::map<std::string, CaseCost>& costs,
                          const std::vector<CampaignPart>& parts);

/// The most MPI processes that a case of the plan, or its reference, runs as.
int most_ranks_of(const Plan& plan, const std::vector<Case>& cases, const Registry& registry);

/// A workflow as it is written.
struct Campaign {
  std::filesystem::path plan;
  std::vector<CampaignPart> parts;
  CampaignEnds ends;
  int threads = 1;     ///< of a contestant
  int most_ranks = 1;  ///< a job has threads x most_ranks processors
};

/// Writes a workflow into `folder`: campaign.json, a file of cases a part, the Snakefile and the profile for
/// Slurm. Throws: InputError if the folder holds something else or cannot be written.
void write_campaign(const Campaign& campaign, const std::filesystem::path& folder);

}  // namespace palpate::experiments

// workflow.
#include <algorithm>
#include <iostream>
#include <memory>

#include "core/base/error.h"
#include "experiments/campaign/campaign.h"
#include "experiments/commands/commands.h"
#include "experiments/commands/usage.h"
#include "experiments/runner/contest_table.h"
#include "experiments/runner/read_plan.h"
#include "experiments/runner/runner.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace {

struct WorkflowArguments {
  std::string plan;
  std::string out;
  std::vector<std::string> costs;
  int threads = 0;
  CampaignSettings settings;
};

int write_workflow(const WorkflowArguments& arguments) {
  const std::filesystem::path file = find_plan(arguments.plan);
  const Registry registry = load_registry(read_contestant_folders(file));
  const Plan plan = read_plan(file, registry);
  const std::vector<Case> cases = build_cases(plan, registry);
  require_available(plan, registry);
  for (const std::string& note : plan.notes) print_note(note);
  const auto costs = read_costs({arguments.costs.begin(), arguments.costs.end()});
  const int threads = arguments.threads > 0 ? arguments.threads : plan.run.threads;
  const auto parts = split_campaign(plan, cases, costs, arguments.settings);
  write_campaign({plan.file, parts, request_ends(plan, cases, costs, parts), threads,
                  most_ranks_of(plan, cases, registry)},
                 arguments.out);
  const auto known =
      std::count_if(cases.begin(), cases.end(), [&](const Case& c) { return costs.count(c.id) > 0; });
  double seconds = 0.0;
  for (const CampaignPart& part : parts) seconds += part.seconds;
  std::cout << cases.size() << " cases in " << parts.size() << " parts, about " << duration_text(seconds)
            << " one after the other; the time of " << known
            << " cases is from records, of the others taken to be "
            << duration_text(arguments.settings.unknown_seconds) << " a repeat\n"
            << "Written: " << arguments.out << "; there: snakemake -j2, or snakemake --profile slurm\n";
  return kDone;
}

}  // namespace

void add_workflow_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<WorkflowArguments>();
  CLI::App* command =
      app.add_subcommand("workflow", "Write a plan as jobs of Snakemake, for this machine or Slurm");
  command
      ->add_option("PLAN", arguments->plan, "Plan file (.yaml), or the bare name of one in experiments/plans")
      ->required();
  command->add_option("-o,--output", arguments->out, "Folder of the workflow")->required()->type_name("DIR");
  command
      ->add_option("--costs", arguments->costs,
                   "A run of the plan whose records tell what its cases take; repeatable")
      ->allow_extra_args(false)
      ->type_name("RUN");
  command
      ->add_option("--job-seconds", arguments->settings.job_seconds,
                   "Put short cases together until a job takes about so long (600)")
      ->check(number_from(0.001, 1e7))
      ->type_name("S");
  command
      ->add_option("--unknown-seconds", arguments->settings.unknown_seconds,
                   "What a repeat takes that no record tells of (10)")
      ->check(number_from(0.001, 1e7))
      ->type_name("S");
  command->add_option("--threads", arguments->threads, "Threads a contestant, in place of the plan's")
      ->transform(whole_number_from(1, 1024))
      ->type_name("N");
  command->footer(
      "The folder has a Snakefile for Snakemake 7, a profile for Slurm and the cases of each job; "
      "docs/campaigns.md\n"
      "says how it is run and what is left when something breaks.");
  command->callback([arguments, &exit_code] { exit_code = write_workflow(*arguments); });
}

}  // namespace palpate::experiments

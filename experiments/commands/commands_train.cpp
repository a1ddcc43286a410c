// train: spring constants, and moduli where a volume model is on, from displacement fields of quadratic
// elements.
#include <iostream>
#include <memory>

#include "core/base/error.h"
#include "experiments/commands/commands.h"
#include "experiments/commands/usage.h"
#include "experiments/files/output_file.h"
#include "experiments/files/scratch_folder.h"
#include "experiments/spring_training/training_report.h"
#include "experiments/spring_training/training_run.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace {

struct TrainArguments {
  std::string plan;
  std::string out;
  std::string moduli;
  int threads = 1;
  bool as_json = false;
};

int train(const TrainArguments& arguments) {
  const TrainingPlan plan = read_training_plan(arguments.plan);
  const bool has_moduli = plan.volume != TrainedVolume::kNone;
  if (has_moduli == arguments.moduli.empty()) {
    throw InputError(has_moduli ? "--moduli: the plan has a volume model: name a file for its moduli"
                                : "--moduli: the plan has no volume model, so there are no moduli to write");
  }
  check_output_csv(arguments.out);
  if (has_moduli) check_output_csv(arguments.moduli);
  Progress progress(arguments.as_json);
  const Registry registry = load_registry();
  const ScratchFolder scratch;
  const TrainingSetting setting{registry, scratch.path(), progress, arguments.threads, nullptr};
  TrainingInput input = build_training_input(plan, setting);
  for (const std::string& note : input.notes) print_note(note);
  const TrainingOutcome outcome = run_training(input, plan, setting);
  write_trained_springs(arguments.out, input, outcome);
  if (has_moduli) write_trained_moduli(arguments.moduli, plan.volume, input, outcome);
  if (arguments.as_json) {
    print_json(build_training_report(input, outcome));
  } else {
    std::cout << training_tables(outcome);
    std::cout << "Written: " << arguments.out << (has_moduli ? ", " + arguments.moduli : "") << '\n';
  }
  return kDone;
}

}  // namespace

void add_train_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<TrainArguments>();
  CLI::App* command =
      app.add_subcommand("train", "Train spring constants on displacement fields of quadratic elements");
  command->add_option("TRAINING", arguments->plan, "Loads, clamps and sets (palpate/training/1)")->required();
  command->add_option("-o,--output", arguments->out, "Springs to write (.csv)")
      ->required()
      ->type_name("FILE");
  command
      ->add_option("--moduli", arguments->moduli, "Moduli to write (.csv), where the plan has a volume model")
      ->type_name("FILE");
  command->add_option("--threads", arguments->threads, "Threads that the quadratic elements may use (1)")
      ->check(whole_number_from(1, 1024))
      ->type_name("N");
  command->add_flag("--json", arguments->as_json, "Print the report as JSON");
  command->callback([arguments, &exit_code] { exit_code = train(*arguments); });
}

}  // namespace palpate::experiments

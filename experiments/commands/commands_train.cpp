// train: spring constants, and moduli where a volume model is on, from displacement fields of quadratic
// elements.
#include <iostream>
#include <memory>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "experiments/commands/commands.h"
#include "experiments/commands/usage.h"
#include "experiments/files/output_file.h"
#include "experiments/files/plain_file.h"
#include "experiments/files/scratch_folder.h"
#include "experiments/spring_training/training_report.h"
#include "experiments/spring_training/training_run.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

struct TrainArguments {
  std::string plan;
  std::string out;
  std::string moduli;
  int threads = 1;
  bool as_json = false;
};

/// Puts what the run left where it was asked for, whole or not at all.
void copy_answer(const std::filesystem::path& from, const std::string& to) {
  const auto bytes = read_bytes(from);
  if (!bytes) throw UnavailableError("training left no " + from.filename().string());
  write_file_atomically(to, *bytes);
}

int train(const TrainArguments& arguments) {
  const TrainingPlan plan = read_training_plan(arguments.plan);
  const bool has_moduli = plan.volume != TrainedVolume::kNone;
  if (has_moduli == arguments.moduli.empty()) {
    throw InputError(has_moduli ? "--moduli: the plan has a volume model: name a file for its moduli"
                                : "--moduli: the plan has no volume model, so there are no moduli to write");
  }
  check_output_csv(arguments.out);
  refuse_output_over_input("-o", arguments.out, {arguments.plan, plan.mesh.file});
  if (has_moduli) {
    check_output_csv(arguments.moduli);
    refuse_output_over_input("--moduli", arguments.moduli, {arguments.plan, plan.mesh.file});
    if (is_same_file(arguments.moduli, arguments.out))
      throw InputError("--moduli: the same file as --output");
  }
  Progress progress(arguments.as_json);
  const Registry registry = load_registry();
  const ScratchFolder scratch;
  const TrainingSetting setting{registry, scratch.path(), progress, arguments.threads, nullptr, print_note};
  const json report = run_training(plan, setting, {scratch.file("springs.csv"), scratch.file("moduli.csv")});
  copy_answer(scratch.file("springs.csv"), arguments.out);
  if (has_moduli) copy_answer(scratch.file("moduli.csv"), arguments.moduli);
  if (arguments.as_json) {
    print_json(report);
  } else {
    std::cout << training_tables(report);
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
      ->transform(whole_number_from(1, 1024))
      ->type_name("N");
  command->add_flag("--json", arguments->as_json, "Print the report as JSON");
  command->callback([arguments, &exit_code] { exit_code = train(*arguments); });
}

}  // namespace palpate::experiments

// train: spring constants, and moduli where a volume model is on, from displacement fields of quadratic
// elements.
#include <unistd.h>

#include <algorithm>
#include <iostream>
#include <memory>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/springs/springs_csv.h"
#include "experiments/commands.h"
#include "experiments/output_file.h"
#include "experiments/training_run.h"
#include "experiments/usage.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

struct TrainArguments {
  std::string plan;
  std::string out;
  std::string moduli;
  int threads = 1;
  bool as_json = false;
};

/// A folder below the system's temporary one, removed at the end.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (fs::temp_directory_path() / "palpate-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr)
      throw InputError(name, 0, "a temporary folder that can be written", "none");
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

json summary(const std::vector<double>& errors) {
  return {{"rms", root_mean_square(errors)}, {"max", *std::max_element(errors.begin(), errors.end())}};
}

json report_of(const TrainingInput& input, const TrainingOutcome& outcome) {
  json report{{"vertices", input.mesh.points.size()},
              {"springs", input.network.springs.size()},
              {"moduli", input.terms.constant.size() - input.network.springs.size()},
              {"ridge", outcome.ridges[outcome.chosen].ridge}};
  for (const RidgeResult& result : outcome.ridges)
    report["ridges"].push_back({{"ridge", result.ridge},
                                {"train_rms", result.train_rms},
                                {"validate_rms", result.validate_rms},
                                {"iterations", result.lbfgs.iterations},
                                {"evaluations", result.lbfgs.evaluations}});
  for (const SplitErrors& split : outcome.errors) {
    json cases = json::array();
    for (std::size_t i = 0; i < split.cases.size(); ++i)
      cases.push_back({{"case", split.cases[i]}, {"before", split.before[i]}, {"after", split.after[i]}});
    report["errors"][split.name] = {
        {"before", summary(split.before)}, {"after", summary(split.after)}, {"cases", cases}};
  }
  return report;
}

void print_outcome(const TrainingOutcome& outcome) {
  const auto percent = [](double error) { return short_number(100.0 * error) + "%"; };
  TextTable table({"set", "case", "before", "trained"}, "llrr");
  for (const SplitErrors& split : outcome.errors) {
    for (std::size_t i = 0; i < split.cases.size(); ++i)
      table.add({split.name, split.cases[i], percent(split.before[i]), percent(split.after[i])});
    table.add(
        {split.name, "rms", percent(root_mean_square(split.before)), percent(root_mean_square(split.after))});
  }
  std::cout << "Relative L2 error of the displacement against quadratic elements\n" << table.text();
  std::cout << "Ridge " << short_number(outcome.ridges[outcome.chosen].ridge)
            << ", chosen by the validation set alone; no choice looked at the test sets.\n";
}

/// The trained moduli of the vertices or tets, one row each.
void write_moduli(const std::string& path, const TrainingInput& input, const TrainingPlan& plan,
                  const std::vector<double>& constant) {
  const bool at_vertices = plan.volume == TrainedVolume::kNodeAverage;
  std::string text = at_vertices ? "vertex,modulus_pa\n" : "tet,modulus_pa\n";
  const std::size_t springs = input.network.springs.size();
  for (std::size_t i = springs; i < constant.size(); ++i) {
    text += std::to_string(i - springs) + ",";
    append_number(text, constant[i]);
    text += '\n';
  }
  write_file_atomically(path, text);
}

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
  const TemporaryFolder scratch;
  TrainingInput input = build_training_input(plan, registry, scratch.path(), arguments.threads, progress);
  for (const std::string& note : input.notes) print_note(note);
  const TrainingOutcome outcome = run_training(input, plan, progress);
  std::copy(outcome.constant.begin(),
            outcome.constant.begin() + static_cast<std::ptrdiff_t>(input.network.springs.size()),
            input.network.stiffness_n_per_m.begin());
  springs::write_springs_csv(arguments.out, input.network);
  if (has_moduli) write_moduli(arguments.moduli, input, plan, outcome.constant);
  if (arguments.as_json) {
    print_json(report_of(input, outcome));
  } else {
    print_outcome(outcome);
    std::cout << "Written: " << arguments.out << '\n';
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

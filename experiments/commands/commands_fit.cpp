// fit: the cheapest model that meets a scene's tolerance within its budget.
#include <cmath>
#include <iostream>
#include <memory>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "experiments/commands/commands.h"
#include "experiments/commands/usage.h"
#include "experiments/fit/fit_output.h"
#include "experiments/processes/stop_signals.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

struct FitArguments {
  std::string scene;
  std::string out;
  std::string candidates;
  double time_limit_s = 300.0;
  bool as_json = false;
};

std::string shown_percent(const json& share) {
  return share.is_number() ? three_digits(100.0 * share.get<double>()) : "-";
}

/// Those that are more accurate than everything cheaper: what more time buys, step by step.
void print_steps(const json& tried, const std::string& folder) {
  TextTable table({"tried", "tets", "error %", "time", "not taken, since"}, "lrrrl");
  double least = 1e300;
  for (const json& point : tried) {
    if (point.at("cost_s").is_null() || point.at("error").empty()) continue;
    const double error = point.at("error").front().get<double>();
    if (error >= least) continue;
    least = error;
    table.add({point.at("name").get<std::string>(), point.at("tets").dump(), three_digits(100.0 * error),
               time_text(point.at("cost_s").get<double>()),
               point.at("why_not").get<std::string>().substr(0, 60)});
  }
  std::cout << table.text() << "What more time buys; all " << tried.size() << " that were tried are in "
            << folder << "/fit.md\n";
}

void print_fit(const json& fit, const std::string& folder) {
  print_steps(fit.at("tried"), folder);
  std::cout << '\n';
  const bool is_met = !fit.at("choice").is_null();
  const json& point = is_met ? fit.at("choice") : fit.at("nearest");
  if (point.is_null()) {
    std::cout << "Nothing gave a figure.\n";
    return;
  }
  const std::string name = point.at("name").get<std::string>();
  if (!is_met) {
    std::cout << colored("Nothing does.", Color::kRed) << " Closest: " << name << ": "
              << point.at("why_not").get<std::string>() << '\n';
    return;
  }
  std::cout << colored("Fitted: ", Color::kGreen) << name << ", " << point.at("tets") << " tetrahedra, "
            << time_text(point.at("cost_s").get<double>()) << " (" << fit.at("work").get<std::string>()
            << "), error at most " << shown_percent(point.at("worst_error")) << "% on the scene and on "
            << kOtherLoads << " other loads\nNext: palpate simulate " << folder << "/scene.yaml -o DIR\n";
}

int fit_model(const FitArguments& arguments) {
  const Registry registry = load_registry();
  FitOptions options;
  options.scene = arguments.scene;
  options.out = arguments.out;
  options.candidates = arguments.candidates;
  options.time_limit_s = arguments.time_limit_s;
  options.stop_flag = catch_stop_signals();
  Progress progress;
  const FitResult result = run_fit(options, registry, progress);
  write_fit(result, options.out);
  progress.say("done in " + duration_text(result.wall_s));
  const json fit = describe_fit(result);
  if (arguments.as_json) {
    print_json(fit);
  } else {
    print_fit(fit, arguments.out);
  }
  if (!result.is_complete) print_note("stopped before all was tried: what is known so far is written");
  if (result.is_interrupted) return kInterrupted;
  return result.choice ? kDone : kNotAccepted;
}

}  // namespace

void add_fit_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<FitArguments>();
  CLI::App* command =
      app.add_subcommand("fit", "Find the cheapest model that meets a scene's tolerance and budget");
  command->add_option("SCENE", arguments->scene, "Scene with the key require (.yaml)")->required();
  command->add_option("-o,--output", arguments->out, "Folder for model, proof and report: new or empty")
      ->required()
      ->type_name("DIR");
  command
      ->add_option("--candidates", arguments->candidates,
                   "What is tried, in place of experiments/fit/candidates.yaml")
      ->type_name("FILE");
  command
      ->add_option("--time-limit", arguments->time_limit_s,
                   "Seconds after which it stops with what is known (300)")
      ->check(number_from(1.0, 1e6))
      ->type_name("S");
  command->add_flag("--json", arguments->as_json, "Print fit.json");
  command->footer(
      "The scene's require says what is to be reached: docs/fit.md. Exit codes: 0 a model meets it, "
      "verified\n"
      "on the scene and on other loads; 1 none does, or none could be verified in time: the nearest is "
      "named;\n"
      "2 bad input; 3 something needed could not run; 130 interrupted.");
  command->callback([arguments, &exit_code] { exit_code = fit_model(*arguments); });
}

}  // namespace palpate::experiments

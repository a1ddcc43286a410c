// fit: the cheapest model that meets a scene's tolerance within its budget. envelope: how far it may be
// taken.
#include <cmath>
#include <iostream>
#include <memory>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "experiments/commands/commands.h"
#include "experiments/commands/usage.h"
#include "experiments/envelope/envelope_output.h"
#include "experiments/files/scratch_folder.h"
#include "experiments/fit/fit_output.h"
#include "experiments/processes/report_script.h"
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
               time_text(point.at("cost_s").get<double>()), point.at("not_taken").get<std::string>()});
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
    std::cout << colored("Nothing was found that does.", Color::kRed) << " Closest: " << name << ": "
              << point.at("why_not").get<std::string>() << '\n';
    return;
  }
  std::cout << colored("Fitted: ", Color::kGreen) << name << ", " << point.at("tets") << " tetrahedra, "
            << time_text(point.at("cost_s").get<double>()) << " (" << fit.at("work").get<std::string>()
            << "), error at most " << shown_percent(point.at("worst_error")) << "% on the scene and on "
            << point.at("error").size() - 1 << " other loads, estimated at most "
            << shown_percent(point.at("estimated_error")) << "% on all like these\nNext: palpate simulate "
            << folder << "/scene.yaml -o DIR\n";
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

struct EnvelopeArguments {
  std::string folder;
  double time_limit_s = 1800.0;
  double within = kEnvelopeResolution - 1.0;
  bool as_json = false;
};

/// envelope.svg and .png beside envelope.json; a note where they cannot be drawn.
void draw_envelope(const std::string& folder) {
  const ScratchFolder scratch;
  ProcessSpec spec = report_script("show_envelope.py", {folder});
  spec.standard_error = scratch.file("error");
  const ProcessResult result = run_process(spec);
  if (result.end != ProcessEnd::kExited || result.exit_code != kDone)
    print_note("the chart could not be drawn: " + last_line(spec.standard_error));
}

void print_envelope(const json& envelope, const std::string& folder) {
  const auto number = [](const json& value) {
    return value.is_number() ? three_digits(value.get<double>()) : std::string("-");
  };
  TextTable table({"axis", "holds up to", "fails at", "by"}, "lrrl");
  for (const json& axis : envelope.at("axes"))
    table.add({axis.at("text").get<std::string>(), number(axis.at("holds_to")), number(axis.at("fails_at")),
               axis.at("ending").is_null() ? "-" : axis.at("ending").get<std::string>()});
  std::cout << table.text() << "Tolerance " << shown_percent(envelope.at("at_most"))
            << "%, errors of reference and time step on top; errors at each factor are in " << folder
            << "/envelope.md\nsimulate warns where " << folder << "/scene.yaml is taken beyond\n";
}

int measure_envelope(const EnvelopeArguments& arguments) {
  const Registry registry = load_registry();
  EnvelopeOptions options;
  options.folder = arguments.folder;
  options.time_limit_s = arguments.time_limit_s;
  options.resolution = 1.0 + arguments.within;
  options.stop_flag = catch_stop_signals();
  Progress progress;
  const EnvelopeResult result = run_envelope(options, registry, progress);
  const json envelope = describe_envelope(result);
  write_envelope(envelope, options.folder);
  if (!result.borders.empty()) draw_envelope(arguments.folder);
  progress.say("done in " + duration_text(result.wall_s));
  if (arguments.as_json) {
    print_json(envelope);
  } else {
    print_envelope(envelope, arguments.folder);
  }
  if (!envelope.at("complete").get<bool>())
    print_note("stopped before all was found: what is known so far is written");
  if (result.is_interrupted) return kInterrupted;
  return envelope.at("complete").get<bool>() && result.at_one.holds() ? kDone : kNotAccepted;
}

}  // namespace

void add_envelope_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<EnvelopeArguments>();
  CLI::App* command =
      app.add_subcommand("envelope", "Measure how far a fitted model may be taken before it fails");
  command->add_option("FIT", arguments->folder, "Folder that palpate fit has written")->required();
  command
      ->add_option("--time-limit", arguments->time_limit_s,
                   "Seconds after which it stops with what is known (1800)")
      ->check(number_from(1.0, 1e6))
      ->type_name("S");
  command
      ->add_option(
          "--within", arguments->within,
          "Share to which each border is brought in (0.1); 1 is a factor of two, with four looks for seven")
      ->check(number_from(0.01, 10.0))
      ->type_name("SHARE");
  command->add_flag("--json", arguments->as_json, "Print envelope.json");
  command->footer(
      "Writes envelope.json, envelope.md and a chart into FIT, and the key envelope into its scene.yaml:\n"
      "simulate then warns where a scene leaves it (docs/fit.md). Exit codes: 0 all borders found; 1 not\n"
      "in time, or the fitted scene itself does not hold; 2 bad input; 3 something needed could not run;\n"
      "130 interrupted.");
  command->callback([arguments, &exit_code] { exit_code = measure_envelope(*arguments); });
}

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

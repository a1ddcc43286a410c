// live: the organ under the hand, in a browser.
#include <iostream>
#include <memory>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "experiments/commands/commands.h"
#include "experiments/commands/usage.h"
#include "experiments/files/output_file.h"
#include "experiments/live/live_page.h"
#include "experiments/live/live_prepare.h"
#include "experiments/live/live_server.h"
#include "experiments/processes/stop_signals.h"
#include "experiments/scene_writer/scene_wish.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace {

struct LiveArguments {
  std::string source;
  std::string out;
  std::uint64_t port = 0;
  double unit_m = 0.0;  ///< 0: guessed
  std::uint64_t vertices = 0;
  Material material = kUsualMaterial;
  bool has_material = false;  ///< that was given
  bool has_port = false;
  bool no_table = false;
};

/// Before any work: the page's file can be written.
void check_page_output(const std::filesystem::path& path) {
  std::error_code error;
  if (path.extension() != ".html")
    throw InputError(path.string(), 0, "a page that ends in .html", "\"" + path.extension().string() + "\"");
  const auto folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  if (!std::filesystem::is_directory(folder, error))
    throw InputError(path.string(), 0, "a page in a folder that exists", "no folder " + folder.string());
}

void describe(const LiveBodyData& body) {
  for (const std::string& note : body.notes) print_note(note);
  std::string levels;
  for (const LiveLevel& level : body.levels)
    levels += (levels.empty() ? "" : ", ") + std::to_string(level.mesh.points.size());
  print_note("vertices at each level: " + levels);
  if (!body.table) print_note("without the finite elements' answer beside it: " + body.no_table);
}

int live(const LiveArguments& arguments) {
  if (!arguments.out.empty()) {
    check_page_output(arguments.out);
    refuse_output_over_input("-o", arguments.out, {arguments.source});
  }
  if (!arguments.out.empty() && arguments.has_port)
    throw InputError("--port", 0, "a page that is served", "--output, which writes it to a file");
  LiveWish wish;
  wish.source = arguments.source;
  if (arguments.unit_m > 0.0) wish.unit_m = arguments.unit_m;
  if (arguments.vertices > 0) wish.vertices = arguments.vertices;
  if (arguments.has_material) wish.material = arguments.material;
  wish.with_table = !arguments.no_table;
  check_live_parts();
  const LiveBodyData body = prepare_live(wish, load_registry());
  describe(body);
  const std::string page = write_live_page(body);
  if (!arguments.out.empty()) {
    write_file_atomically(arguments.out, page);
    std::cout << "Written: " << arguments.out << '\n';
    return kDone;
  }
  const volatile std::sig_atomic_t* stop = catch_stop_signals();
  serve_live_page(page, static_cast<std::uint16_t>(arguments.port), *stop, [](std::uint16_t port) {
    std::cout << "http://127.0.0.1:" << port << "/" << std::endl;
    print_note("open it in a browser on this machine; Ctrl-C ends it");
  });
  return kDone;
}

}  // namespace

void add_live_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<LiveArguments>();
  CLI::App* command = app.add_subcommand("live", "Press an organ with the mouse, in a browser");
  command->add_option("SOURCE", arguments->source, "Mesh or surface, scene (.yaml), or folder of a fit")
      ->required();
  command->add_option("-o,--output", arguments->out, "Write the page to a file instead of serving it")
      ->type_name("FILE");
  command->add_option("--port", arguments->port, "Port on 127.0.0.1 (a free one)")
      ->transform(whole_number_from(1, 65535))
      ->type_name("N");
  command->add_option("--unit-m", arguments->unit_m, "A mesh's unit in metres; without it, it is guessed")
      ->check(number_from(1e-9, 1e6))
      ->type_name("M");
  command->add_option("--vertices", arguments->vertices, "Of a surface's filling (1500)")
      ->transform(whole_number_from(10, 1000000))
      ->type_name("N");
  command
      ->add_option("--young-pa", arguments->material.young_modulus_pa,
                   "Young's modulus of a mesh, Pa (10000)")
      ->check(number_from(1e-6, kMostNumber));
  command->add_option("--poisson", arguments->material.poisson_ratio, "Poisson's ratio of a mesh (0.45)")
      ->check(number_from(-0.99, 0.4999));
  command->add_option("--density", arguments->material.density_kg_m3, "Density of a mesh, kg/m^3 (1050)")
      ->check(number_from(1e-6, kMostNumber));
  command->add_flag("--no-table", arguments->no_table,
                    "Leave out the finite elements' answer (seconds to make, megabytes in the page)");
  command->footer(
      "Prints the address of the page, which only this machine can open, and serves it until Ctrl-C. The "
      "page "
      "holds\n"
      "the engine itself, compiled to WebAssembly, and asks for nothing else: with -o it opens offline "
      "anywhere.\n"
      "docs/live.md says what can be done in it.");
  command->callback([arguments, command, &exit_code] {
    for (const char* name : {"--young-pa", "--poisson", "--density"})
      arguments->has_material = arguments->has_material || command->count(name) > 0;
    arguments->has_port = command->count("--port") > 0;
    exit_code = live(*arguments);
  });
}

}  // namespace palpate::experiments

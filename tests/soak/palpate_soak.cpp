// Palpates one body for as long as it is told, and writes a line a cycle. soak.py starts it and judges what
// it wrote.
//
//     palpate_soak '{"source": FILE or "cube:N", "vertices": N, "model": "springs" or "smoothed", "cycles":
//     N, "wall_s": S, "seed": N,
//                   "depth_share": X, "step_share": X}' OUT.csv
//
// Standard output: one line of JSON with what the body is. Ctrl-C and kill end it after the cycle that it is
// in. Exit codes: 0 done, 1 the body broke, 2 bad input, 3 something needed could not run.
#include <unistd.h>

#include <array>
#include <charconv>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/base/stopwatch.h"
#include "core/mesh/geometry.h"
#include "experiments/live/live_prepare.h"
#include "experiments/processes/child/sanitizers.h"
#include "experiments/processes/stop_signals.h"
#include "experiments/registry/registry.h"
#include "tests/soak/palpation.h"
#include "tests/support/live_cases.h"

namespace palpate::soak {
namespace {

using nlohmann::json;

constexpr const char* kHeader =
    "cycle,simulated_s,steps,vertex,depth_m,slid,pressed_kinetic_j,pressed_elastic_j,pressed_load_j,pressed_"
    "force_n,"
    "pressed_largest_m,pressed_inverted,rest_kinetic_j,rest_elastic_j,rest_load_j,rest_largest_m,rest_mean_x_"
    "m,"
    "rest_mean_y_m,rest_mean_z_m,rest_inverted,broken,hash,rss_bytes,wall_s\n";

struct Body {
  live::BodySetup setup;
  FingerOptions finger;
};

/// "cube:N", a cube of the tests with N cells a side, or whatever `palpate live` takes.
Body make_body(const json& wish) {
  const auto source = wish.at("source").get<std::string>();
  Body out;
  if (source.starts_with("cube:")) {
    int cells = 0;
    const char* end = source.data() + source.size();
    const auto read = std::from_chars(source.data() + 5, end, cells);
    if (read.ec != std::errc() || read.ptr != end || cells < 2 || cells > 100)
      throw InputError("source", 0, "cube:N with N from 2 to 100", source);
    out.setup = testing_support::make_live_cube(cells);
    out.finger.radius_m = 0.015;
    return out;
  }
  experiments::LiveWish live_wish;
  live_wish.source = source;
  live_wish.with_table = false;
  if (wish.contains("vertices")) live_wish.vertices = wish.at("vertices").get<std::uint64_t>();
  experiments::LiveBodyData data = prepare_live(live_wish, experiments::load_registry());
  experiments::LiveLevel& level = data.levels.front();
  out.setup = {std::move(level.mesh), std::move(level.holding), std::move(level.springs),
               data.damping_stiffness_s, data.damping_mass_per_s};
  out.finger.radius_m = data.pad_radius_m;
  out.finger.stiffness_pa_per_m = data.pad_pa_per_m;
  return out;
}

live::ModelChoice choose_model(const json& wish) {
  const auto model = wish.at("model").get<std::string>();
  if (model != "springs" && model != "smoothed")
    throw InputError("model", 0, "springs or smoothed", "\"" + model + "\"");
  live::ModelChoice choice;
  choice.is_smoothed = model == "smoothed";
  choice.spring.strain = choice.blend.strain = StrainSize::kLarge;
  return choice;
}

std::uint64_t resident_bytes() {
  std::uint64_t all = 0;
  std::uint64_t resident = 0;
  if (!(std::ifstream("/proc/self/statm") >> all >> resident))
    throw UnavailableError("cannot tell the memory of this process: expected it in /proc/self/statm");
  return resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

template <typename... Numbers>
void append_numbers(std::string& line, Numbers... values) {
  const auto one = [&](auto value) {
    append_number(line, value);
    line += ',';
  };
  (one(values), ...);
}

std::string line_of(std::uint64_t cycle, const CycleFigures& f, std::uint64_t steps, double wall_s) {
  std::string line;
  append_numbers(line, cycle, f.rest.time_s, steps, f.vertex, f.depth_m, f.has_slid ? 1 : 0);
  append_numbers(line, f.pressed.kinetic_j, f.pressed.elastic_j, f.pressed.load_j,
                 length(f.pressed.pad_force_n), f.pressed.largest_m, f.pressed.inverted);
  append_numbers(line, f.rest.kinetic_j, f.rest.elastic_j, f.rest.load_j, f.rest.largest_m);
  append_numbers(line, f.mean_offset_m.x, f.mean_offset_m.y, f.mean_offset_m.z, f.rest.inverted,
                 f.rest.is_broken ? 1 : 0);
  line += f.hash + ',';
  append_numbers(line, resident_bytes(), wall_s);
  line.back() = '\n';
  return line;
}

json describe(const live::LiveBody& body, const Palpation& palpation, const Body& made) {
  const BoundingBox box = bounding_box(made.setup.mesh.points);
  return {{"vertices", made.setup.mesh.points.size()},
          {"tets", made.setup.mesh.tets.size()},
          {"springs", made.setup.springs.springs.size()},
          {"longest_side_m", longest_side(box)},
          {"engine", body.stepper().engine},
          {"step_s", palpation.step_s()},
          {"steps_per_tick", palpation.steps_per_tick()},
          {"cycle_s", 1e-3 * static_cast<double>(kCycleTicks)},
          {"pad_radius_m", made.finger.radius_m},
          {"pad_pa_per_m", made.finger.stiffness_pa_per_m},
          {"deepest_m", made.finger.deepest_m},
          {"sanitized", experiments::kIsSanitized}};
}

int run(const json& wish, const std::string& out) {
  Body made = make_body(wish);
  const double side_m = longest_side(bounding_box(made.setup.mesh.points));
  made.finger.seed = wish.at("seed").get<std::uint64_t>();
  made.finger.share_of_bound = wish.at("step_share").get<double>();
  made.finger.deepest_m = wish.at("depth_share").get<double>() * side_m;
  live::LiveBody body(made.setup, choose_model(wish));
  Palpation palpation(body, made.finger);
  std::cout << describe(body, palpation, made).dump() << std::endl;

  std::ofstream csv(out, std::ios::binary);
  csv << kHeader;
  const volatile std::sig_atomic_t* stop = experiments::catch_stop_signals();
  const auto cycles = wish.at("cycles").get<std::uint64_t>();
  const auto wall_s = wish.at("wall_s").get<double>();
  const Stopwatch watch;
  bool is_whole = true;
  for (std::uint64_t cycle = 1; cycle <= cycles && is_whole && *stop == 0 && watch.seconds() < wall_s;
       ++cycle) {
    const CycleFigures figures = palpation.run_cycle();
    is_whole = !figures.rest.is_broken;
    csv << line_of(cycle, figures, cycle * kCycleTicks * palpation.steps_per_tick(), watch.seconds())
        << std::flush;
    if (!csv) throw UnavailableError("cannot write " + out);
  }
  return is_whole ? 0 : 1;
}

int run_main(int argc, char** argv) {
  try {
    if (argc != 3)
      throw InputError("palpate_soak", 0, "its wishes as JSON, and a file to write", "something else");
    return run(json::parse(argv[1]), argv[2]);
  } catch (const InputError& error) {
    std::cerr << "palpate_soak: " << error.what() << '\n';
    return 2;
  } catch (const json::exception& error) {
    std::cerr << "palpate_soak: the wishes are not as they should be: " << error.what() << '\n';
    return 2;
  } catch (const std::exception& error) {
    std::cerr << "palpate_soak: " << error.what() << '\n';
    return 3;
  }
}

}  // namespace
}  // namespace palpate::soak

int main(int argc, char** argv) {
  return palpate::soak::run_main(argc, argv);
}

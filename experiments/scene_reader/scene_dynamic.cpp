#include "experiments/scene_reader/scene_dynamic.h"

#include <cmath>

#include "core/base/error.h"
#include "experiments/scene_reader/region.h"
#include "experiments/text/nearest_name.h"

namespace palpate::experiments {
namespace {

double read_above_zero(const YamlValue& value) {
  const double number = value.number();
  if (!(number > 0.0) || !std::isfinite(number)) value.fail_expected("a number above 0");
  return number;
}

double read_not_negative(const YamlValue& value) {
  const double number = value.number();
  if (!(number >= 0.0) || !std::isfinite(number)) value.fail_expected("a number from 0");
  return number;
}

void read_integrator(const YamlValue& value, SceneDynamic& out) {
  std::vector<std::string> known{reference::kExponential};
  out.is_exponential = value.text() == known.front();
  if (out.is_exponential) return;
  for (const dynamics::IntegratorKind kind : dynamics::kIntegrators) {
    known.emplace_back(dynamics::integrator_name(kind));
    if (known.back() != value.text()) continue;
    out.integrator = kind;
    return;
  }
  value.fail("unknown integrator \"" + value.text() + "\"" + nearest_hint(value.text(), known));
}

reference::EngineChoice read_engine(const YamlValue& value) {
  const std::vector<std::string> known{"auto", "general", "plain", "tets"};
  if (value.text() == known[0]) return reference::EngineChoice::kAuto;
  if (value.text() == known[1]) return reference::EngineChoice::kGeneral;
  if (value.text() == known[2]) return reference::EngineChoice::kPlain;
  if (value.text() == known[3]) return reference::EngineChoice::kTets;
  value.fail("unknown engine \"" + value.text() + "\"" + nearest_hint(value.text(), known));
}

bool is_single(const YamlValue& value) {
  if (value.text() != "single" && value.text() != "double") value.fail_expected("single or double");
  return value.text() == "single";
}

void read_damping(const YamlValue& value, SceneDynamic& out) {
  const YamlFields fields =
      value.fields({"stiffness_s", "mass_per_s", "spring_n_s_per_m", "vertex_n_s_per_m", "springs"});
  const auto take = [&](const char* key, double& into) {
    const auto found = fields.find(key);
    if (found) into = read_not_negative(*found);
    return found.has_value();
  };
  const bool by_stiffness = take("stiffness_s", out.damping_stiffness_s);
  const bool by_spring = take("spring_n_s_per_m", out.damping_spring_n_s_per_m);
  if (by_stiffness && by_spring) value.fail("damping takes stiffness_s or spring_n_s_per_m, not both");
  const bool by_mass = take("mass_per_s", out.damping_mass_per_s);
  const bool by_vertex = take("vertex_n_s_per_m", out.damping_vertex_n_s_per_m);
  if (by_mass && by_vertex) value.fail("damping takes mass_per_s or vertex_n_s_per_m, not both");
  const auto springs = fields.find("springs");
  if (!springs) return;
  if (springs->text() != "axial" && springs->text() != "isotropic")
    springs->fail_expected("axial or isotropic");
  out.spring_damping = dynamics::parse_spring_damping(springs->text());
}

void read_solver(const YamlValue& value, SceneDynamic& out) {
  constexpr std::int64_t kMostIterations = 100'000;
  constexpr std::int64_t kMostSubsteps = 10'000;
  const YamlFields fields = value.fields({"iterations", "tolerance", "substeps"});
  if (const auto iterations = fields.find("iterations"))
    out.solver.iterations = static_cast<std::size_t>(iterations->integer(1, kMostIterations));
  if (const auto tolerance = fields.find("tolerance")) out.solver.tolerance = tolerance->number(0.0, 1.0);
  if (const auto substeps = fields.find("substeps"))
    out.substeps = static_cast<std::size_t>(substeps->integer(1, kMostSubsteps));
  out.has_solver = true;
}

/// Sets what a preset sets. Only its kind of spring damping may be given beside it.
void apply_preset(const YamlValue& preset, const YamlFields& fields, SceneDynamic& out) {
  const std::vector<std::string> known{kThesisPreset};
  if (preset.text() != kThesisPreset)
    preset.fail("unknown preset \"" + preset.text() + "\"" + nearest_hint(preset.text(), known));
  for (const char* key : {"integrator", "time_step_s", "safety", "mass_per_vertex_kg", "speed_limit_m_s"}) {
    if (const auto given = fields.find(key))
      given->fail("the preset " + preset.text() + " sets " + key + " by itself");
  }
  if (out.damping_stiffness_s + out.damping_mass_per_s + out.damping_spring_n_s_per_m +
          out.damping_vertex_n_s_per_m >
      0.0)
    preset.fail("the preset " + preset.text() +
                " sets the damping by itself; \"springs\" alone may be given");
  out.preset = preset.text();
  out.integrator = dynamics::IntegratorKind::kSymplecticEuler;
  out.time_step_s = ThesisTable::kTimeStepS;
  out.mass_per_vertex_kg = ThesisTable::kMassKg;
  out.damping_spring_n_s_per_m = ThesisTable::kSpringDampingNSPerM;
  out.damping_vertex_n_s_per_m = ThesisTable::kVertexDampingNSPerM;
}

std::vector<double> read_numbers(const YamlValue& value) {
  std::vector<double> out;
  for (const YamlValue& item : value.items()) {
    out.push_back(item.number());
    if (!std::isfinite(out.back())) item.fail_expected("a finite number");
  }
  return out;
}

}  // namespace

SceneDynamic read_dynamic(const YamlValue& value) {
  constexpr std::int64_t kMostFrames = 1'000'000'000;
  const YamlFields fields = value.fields(
      {"integrator", "time_step_s", "safety", "duration_s", "allow_unstable", "mass_per_vertex_kg", "damping",
       "speed_limit_m_s", "frames", "samples", "probes_m", "preset", "engine", "precision", "solver"});
  SceneDynamic out;
  if (const auto damping = fields.find("damping")) read_damping(*damping, out);
  if (const auto preset = fields.find("preset")) {
    apply_preset(*preset, fields, out);
  } else {
    read_integrator(fields.need("integrator"), out);
    const YamlValue step = fields.need("time_step_s");
    if (step.text() != "auto") out.time_step_s = read_above_zero(step);
  }
  if (const auto safety = fields.find("safety")) {
    out.safety = safety->number(1e-6, 1.0);
    out.has_safety = true;
  }
  out.duration_s = read_above_zero(fields.need("duration_s"));
  if (const auto allow = fields.find("allow_unstable")) out.allow_unstable = allow->boolean();
  if (const auto engine = fields.find("engine")) out.engine = read_engine(*engine);
  if (const auto precision = fields.find("precision")) out.single_precision = is_single(*precision);
  if (const auto solver = fields.find("solver")) read_solver(*solver, out);
  if (const auto mass = fields.find("mass_per_vertex_kg")) out.mass_per_vertex_kg = read_above_zero(*mass);
  if (const auto limit = fields.find("speed_limit_m_s")) out.speed_limit_m_s = read_above_zero(*limit);
  if (const auto frames = fields.find("frames"))
    out.frames = static_cast<std::uint64_t>(frames->integer(0, kMostFrames));
  if (const auto samples = fields.find("samples"))
    out.samples = static_cast<std::uint64_t>(samples->integer(1, kMostFrames));
  if (const auto probes = fields.find("probes_m")) {
    for (const YamlValue& item : probes->items()) out.probes_m.push_back(read_vector(item));
  }
  return out;
}

dynamics::TimeProfile read_profile(const YamlValue& value) {
  const YamlFields fields = value.fields({"times_s", "shares", "smooth"});
  dynamics::TimeProfile profile{read_numbers(fields.need("times_s")), read_numbers(fields.need("shares")),
                                false};
  if (const auto smooth = fields.find("smooth")) profile.smooth = smooth->boolean();
  try {
    validate(profile);
  } catch (const InputError& error) {
    value.fail(error.what());
  }
  return profile;
}

}  // namespace palpate::experiments

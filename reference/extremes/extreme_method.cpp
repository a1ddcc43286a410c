#include "reference/extremes/extreme_method.h"

#include "core/base/error.h"
#include "reference/door/request_options.h"
#include "reference/extremes/modal_stepper.h"

namespace palpate::reference {

using nlohmann::json;
using Engine = ExtremeMethod::Engine;

std::unique_ptr<dynamics::BodyStepper> ExtremeMethod::make(const dynamics::MotionModel& model,
                                                           const StabilityTask& task, int threads) const {
  if (engine == Engine::kPlain) return dynamics::make_plain_stepper(model, precision, threads);
  if (engine == Engine::kTets) return dynamics::make_tet_stepper(model, precision, threads);
  if (engine == Engine::kModes) return make_modal_stepper(model, task, modes);
  dynamics::IntegratorOptions options;
  options.kind = kind;
  options.threads = threads;
  options.linear.threads = threads;
  options.solver = solver;
  return dynamics::make_stepper(model, options);
}

ExtremeMethod take_method(const std::string& name, json& options) {
  const std::string prefix = "motion.";
  if (!name.starts_with(prefix)) throw InputError("method", 0, "motion.INTEGRATOR", name);
  ExtremeMethod out;
  out.name = name.substr(prefix.size());
  if (out.name == "plain_double" || out.name == "plain_float") out.engine = Engine::kPlain;
  if (out.name == "tets_double" || out.name == "tets_float") out.engine = Engine::kTets;
  if (out.name == "modal") out.engine = Engine::kModes;
  if (out.name.ends_with("_float")) out.precision = dynamics::Precision::kSingle;
  if (out.engine == Engine::kGeneral) out.kind = dynamics::parse_integrator(out.name);
  out.solver.iterations = static_cast<std::size_t>(
      take_whole(options, "iterations", 1, 100'000, static_cast<long long>(out.solver.iterations)));
  const bool sweeps =
      out.kind == dynamics::IntegratorKind::kXpbd || out.kind == dynamics::IntegratorKind::kVbd;
  out.solver.tolerance = take_number(options, "tolerance", 0.0, 1.0, sweeps ? 0.0 : out.solver.tolerance);
  out.modes =
      static_cast<std::size_t>(take_whole(options, "modes", 1, 1000, static_cast<long long>(out.modes)));
  return out;
}

}  // namespace palpate::reference

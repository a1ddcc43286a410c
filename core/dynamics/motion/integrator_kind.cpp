#include "core/dynamics/motion/integrator_kind.h"

#include "core/base/enum_names.h"

namespace palpate::dynamics {
namespace {

constexpr EnumNames<IntegratorKind, 11> kNames{
    "integrator",
    {"explicit_euler", "symplectic_euler", "velocity_verlet", "runge_kutta_4", "implicit_euler",
     "prefactored", "backward_euler", "bdf2", "trapezoidal", "xpbd", "vbd"}};

}  // namespace

bool is_implicit(IntegratorKind kind) {
  return kind >= IntegratorKind::kImplicitEuler;
}

IntegratorKind parse_integrator(std::string_view name) {
  return kNames.parse(name);
}

const char* integrator_name(IntegratorKind kind) {
  return kNames.of(kind);
}

}  // namespace palpate::dynamics

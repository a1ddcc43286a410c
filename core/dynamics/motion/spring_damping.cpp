#include "core/dynamics/motion/spring_damping.h"

#include "core/base/enum_names.h"

namespace palpate::dynamics {
namespace {

constexpr EnumNames<SpringDamping, 2> kDampingNames{"spring damping", {"axial", "isotropic"}};

}  // namespace

SpringDamping parse_spring_damping(std::string_view name) {
  return kDampingNames.parse(name);
}

const char* spring_damping_name(SpringDamping damping) {
  return kDampingNames.of(damping);
}

}  // namespace palpate::dynamics

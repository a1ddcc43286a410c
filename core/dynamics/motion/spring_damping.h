// The ways in which springs are damped by name: who has to know of them and moves nothing needs no more than
// this.
#pragma once

#include <string_view>

namespace palpate::dynamics {

/// How a spring resists the relative velocity w = v_b - v_a of its ends (force on a):
///
///   kAxial      c (w . n) n, n along the spring: a rotation is not resisted
///   kIsotropic  c w, as the thesis's eq. 3.2 has it (sign corrected): resists rotations too
enum class SpringDamping { kAxial, kIsotropic };

/// "axial" or "isotropic". Throws: InputError.
SpringDamping parse_spring_damping(std::string_view name);
/// The name that parse_spring_damping reads.
const char* spring_damping_name(SpringDamping damping);

}  // namespace palpate::dynamics

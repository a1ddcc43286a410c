// Eight domains at a time on every processor.
#include "core/dynamics/tet_engine/domain_kernel.h"

#include "core/base/lanes.h"
#include "core/dynamics/tet_engine/domain_lanes.h"

namespace palpate::dynamics {
namespace {

/// Two halves of four lanes: what every processor has.
template <typename Real>
struct EightOfAny {
  using Number = Real;
  using Half = Lanes<Real>;

  Half low;
  Half high;

  static EightOfAny of(Real all) { return {Half::of(all), Half::of(all)}; }
  static EightOfAny load(const Real* eight) { return {Half::load(eight), Half::load(eight + 4)}; }
  void store(Real* eight) const {
    low.store(eight);
    high.store(eight + 4);
  }
  friend EightOfAny operator+(const EightOfAny& a, const EightOfAny& b) {
    return {a.low + b.low, a.high + b.high};
  }
  friend EightOfAny operator-(const EightOfAny& a, const EightOfAny& b) {
    return {a.low - b.low, a.high - b.high};
  }
  friend EightOfAny operator*(const EightOfAny& a, const EightOfAny& b) {
    return {a.low * b.low, a.high * b.high};
  }
  friend EightOfAny operator/(const EightOfAny& a, const EightOfAny& b) {
    return {a.low / b.low, a.high / b.high};
  }
  friend bool any_less(const EightOfAny& a, const EightOfAny& b) {
    return any_less(a.low, b.low) || any_less(a.high, b.high);
  }
  static Vec3Lanes<EightOfAny> load_rows(const Real* rows, const std::uint16_t* at) {
    const auto low = Half::turn(Half::load(rows + at[0]), Half::load(rows + at[1]), Half::load(rows + at[2]),
                                Half::load(rows + at[3]));
    const auto high = Half::turn(Half::load(rows + at[4]), Half::load(rows + at[5]), Half::load(rows + at[6]),
                                 Half::load(rows + at[7]));
    return {{low[0], high[0]}, {low[1], high[1]}, {low[2], high[2]}};
  }
  static void add_rows(Real* rows, const std::uint16_t* at, const Vec3Lanes<EightOfAny>& what) {
    const Half zero = Half::of(0);
    const auto low = Half::turn(what.x.low, what.y.low, what.z.low, zero);
    const auto high = Half::turn(what.x.high, what.y.high, what.z.high, zero);
    for (std::size_t i = 0; i < 4; ++i) (Half::load(rows + at[i]) + low[i]).store(rows + at[i]);
    for (std::size_t i = 0; i < 4; ++i) (Half::load(rows + at[4 + i]) + high[i]).store(rows + at[4 + i]);
  }
};

}  // namespace

template <typename Real>
void add_domain_forces(const DomainLaw& law, const DomainRun<Real>& run, const BlockMotion<Real>& motion,
                       Real* force) {
  add_forces_in_lanes<EightOfAny<Real>>(law, run, motion, force);
}

template void add_domain_forces(const DomainLaw&, const DomainRun<float>&, const BlockMotion<float>&, float*);
template void add_domain_forces(const DomainLaw&, const DomainRun<double>&, const BlockMotion<double>&,
                                double*);

}  // namespace palpate::dynamics

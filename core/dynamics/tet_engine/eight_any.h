// Eight numbers on every processor, as matrix_lanes.h asks for them.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/lanes.h"
#include "core/dynamics/tet_engine/matrix_lanes.h"

namespace palpate::dynamics {

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
  friend EightOfAny min(const EightOfAny& a, const EightOfAny& b) {
    return {min(a.low, b.low), min(a.high, b.high)};
  }
  friend EightOfAny max(const EightOfAny& a, const EightOfAny& b) {
    return {max(a.low, b.low), max(a.high, b.high)};
  }
  friend EightOfAny sqrt(const EightOfAny& a) { return {sqrt(a.low), sqrt(a.high)}; }
  friend bool any_less(const EightOfAny& a, const EightOfAny& b) {
    return any_less(a.low, b.low) || any_less(a.high, b.high);
  }
  template <typename Place>
  static RowLanes<EightOfAny> load_whole_rows(const Real* rows, const Place* at) {
    const auto low = Half::turn(Half::load(rows + at[0]), Half::load(rows + at[1]), Half::load(rows + at[2]),
                                Half::load(rows + at[3]));
    const auto high = Half::turn(Half::load(rows + at[4]), Half::load(rows + at[5]), Half::load(rows + at[6]),
                                 Half::load(rows + at[7]));
    return {{{low[0], high[0]}, {low[1], high[1]}, {low[2], high[2]}}, {low[3], high[3]}};
  }
  template <typename Place>
  static Vec3Lanes<EightOfAny> load_rows(const Real* rows, const Place* at) {
    return load_whole_rows(rows, at).xyz;
  }
  template <typename Place>
  static void store_whole_rows(Real* rows, const Place* at, const RowLanes<EightOfAny>& what) {
    const auto low = Half::turn(what.xyz.x.low, what.xyz.y.low, what.xyz.z.low, what.w.low);
    const auto high = Half::turn(what.xyz.x.high, what.xyz.y.high, what.xyz.z.high, what.w.high);
    for (std::size_t i = 0; i < 4; ++i) low[i].store(rows + at[i]);
    for (std::size_t i = 0; i < 4; ++i) high[i].store(rows + at[4 + i]);
  }
  static void add_rows(Real* rows, const std::uint16_t* at, const Vec3Lanes<EightOfAny>& what) {
    const Half zero = Half::of(0);
    const auto low = Half::turn(what.x.low, what.y.low, what.z.low, zero);
    const auto high = Half::turn(what.x.high, what.y.high, what.z.high, zero);
    for (std::size_t i = 0; i < 4; ++i) (Half::load(rows + at[i]) + low[i]).store(rows + at[i]);
    for (std::size_t i = 0; i < 4; ++i) (Half::load(rows + at[4 + i]) + high[i]).store(rows + at[4 + i]);
  }
};

}  // namespace palpate::dynamics

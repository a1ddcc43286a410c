#include "core/base/lanes.h"

#include <gtest/gtest.h>

#include <array>

#include "core/base/random.h"

namespace palpate {
namespace {

template <typename Real>
void compare_lanes() {
  SplitMix64 random(7);
  std::array<std::array<Real, 4>, 4> in{};
  for (int round = 0; round < 100; ++round) {
    for (auto& four : in) {
      for (Real& each : four) each = static_cast<Real>(random.uniform() + 0.1);
    }
    const auto bits = [&](auto lanes) {
      using L = decltype(lanes);
      std::array<L, 4> v{L::load(in[0].data()), L::load(in[1].data()), L::load(in[2].data()),
                         L::load(in[3].data())};
      for (L& each : v) {
        std::array<Real, 4> four{};
        each.store(four.data());
        four[3] = 0;  // vectors (x, y, z, 0), as sums takes them
        each = L::load(four.data());
      }
      const L some = L::sums(v[0], v[1], v[2], v[3]) / sqrt(max(v[0], L::of(Real(0.5)))) +
                     min(v[1], v[2]) * (v[3] - v[0]);
      std::array<Real, 4> out{};
      some.store(out.data());
      return out;
    };
    ASSERT_EQ(bits(Lanes<Real>{}), bits(PortableLanes<Real>{}));
  }
}

TEST(Lanes, BothFormsGiveTheSameBits) {
  compare_lanes<float>();
  compare_lanes<double>();
}

template <typename L, typename Real>
void expect_columns(const std::array<std::array<Real, 4>, 4>& rows) {
  const std::array<L, 4> columns = L::turn(L::load(rows[0].data()), L::load(rows[1].data()),
                                           L::load(rows[2].data()), L::load(rows[3].data()));
  for (std::size_t i = 0; i < 4; ++i) {
    std::array<Real, 4> column{};
    columns[i].store(column.data());
    for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(column[k], rows[k][i]) << i << ' ' << k;
  }
}

TEST(Lanes, TurnRowsIntoColumns) {
  const std::array<std::array<float, 4>, 4> rows{
      {{0, 1, 2, 3}, {4, 5, 6, 7}, {8, 9, 10, 11}, {12, 13, 14, 15}}};
  const std::array<std::array<double, 4>, 4> wide{
      {{0, 1, 2, 3}, {4, 5, 6, 7}, {8, 9, 10, 11}, {12, 13, 14, 15}}};
  expect_columns<Lanes<float>>(rows);
  expect_columns<PortableLanes<float>>(rows);
  expect_columns<Lanes<double>>(wide);
  expect_columns<PortableLanes<double>>(wide);
}

TEST(Lanes, TellWhetherAnyIsLess) {
  const auto any = [](auto lanes, const auto& a, const auto& b) {
    using L = decltype(lanes);
    return any_less(L::load(a.data()), L::load(b.data()));
  };
  const std::array<float, 4> low{1, 2, 3, 4};
  const std::array<double, 4> wide_low{1, 2, 3, 4};
  for (std::size_t lane = 0; lane < 4; ++lane) {
    std::array<float, 4> high = low;
    high[lane] += 1;
    EXPECT_TRUE(any(Lanes<float>{}, low, high) && any(PortableLanes<float>{}, low, high));
    EXPECT_FALSE(any(Lanes<float>{}, high, low) || any(PortableLanes<float>{}, high, low));
    std::array<double, 4> wide = wide_low;
    wide[lane] += 1;
    EXPECT_TRUE(any(Lanes<double>{}, wide_low, wide) && any(PortableLanes<double>{}, wide_low, wide));
    EXPECT_FALSE(any(Lanes<double>{}, wide, wide_low) || any(PortableLanes<double>{}, wide, wide_low));
  }
}

}  // namespace
}  // namespace palpate

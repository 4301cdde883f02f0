#include "ipm_mapping/fpga/fixed_point.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace ipm_mapping::fpga {
namespace {

using Small = Fixed<6, 3>;                          // -4 ... 3.875 in eighths
using SmallUnsigned = Fixed<5, 2, Sign::Unsigned>;  // 0 ... 3.875 in eighths

template <class F>
double real(F value) {
  return std::ldexp(static_cast<double>(value.raw()), -F::fraction_bits);
}

template <class F, class Use>
void forAll(Use&& use) {
  for (auto raw = F::lowest(); raw <= F::highest(); ++raw) use(F::fromRaw(raw));
}

TEST(FixedPoint, SumsDifferencesAndProductsOfAllOperandsAreExact) {
  forAll<Small>([](Small a) {
    forAll<SmallUnsigned>([a](SmallUnsigned b) {
      ASSERT_EQ(real(a + b), real(a) + real(b));
      ASSERT_EQ(real(a - b), real(a) - real(b));
      ASSERT_EQ(real(b - a), real(b) - real(a));
      ASSERT_EQ(real(a * b), real(a) * real(b));
    });
  });
}

TEST(FixedPoint, ResultTypesHoldTheExtremes) {
  const auto low = Small::fromRaw(Small::lowest());
  const auto high = SmallUnsigned::fromRaw(SmallUnsigned::highest());
  using Sum = decltype(low + high);
  EXPECT_LE((low * low).raw(), decltype(low * low)::highest());
  EXPECT_GE((low - high).raw(), decltype(low - high)::lowest());
  EXPECT_EQ(Sum::fraction_bits, 3);
  EXPECT_EQ(Sum::integer_bits, 4);
  EXPECT_TRUE(Sum::is_signed);
}

TEST(FixedPoint, DivisionTruncatesTowardZeroForAllOperands) {
  forAll<Small>([](Small a) {
    forAll<SmallUnsigned>([a](SmallUnsigned b) {
      if (b.raw() == 0) return;
      ASSERT_EQ(real(divide<4>(a, b)), std::trunc(real(a) / real(b) * 16.0) / 16.0);
    });
  });
}

TEST(FixedPoint, DroppedBitsFloorSoThatNegativeValuesFallToo) {
  forAll<Small>([](Small a) { ASSERT_EQ(real(dropFraction<1>(a)), std::floor(real(a) * 2) / 2); });
}

TEST(FixedPoint, ConversionRoundsAsItsTypeSays) {
  using Floored = Fixed<4, 4, Sign::Signed, Rounding::Floor, Overflow::Refuse>;
  using Truncated = Fixed<4, 4, Sign::Signed, Rounding::TowardZero, Overflow::Refuse>;
  using Nearest = Fixed<4, 4, Sign::Signed, Rounding::NearestAway, Overflow::Refuse>;
  forAll<Small>([](Small a) {
    ASSERT_EQ(real(*fit<Floored>(a)), std::floor(real(a)));
    ASSERT_EQ(real(*fit<Truncated>(a)), std::trunc(real(a)));
    ASSERT_EQ(real(*fit<Nearest>(a)), std::round(real(a)));
  });
}

TEST(FixedPoint, SaturationClampsAndCountsOnlyWhatDoesNotFit) {
  using Narrow = Fixed<4, 1, Sign::Signed, Rounding::Floor, Overflow::Saturate>;  // -1 ... 0.875
  std::uint64_t count = 0, expected = 0;
  forAll<Small>([&](Small a) {
    const double clamped = std::fmin(std::fmax(real(a), -1.0), 0.875);
    expected += clamped != real(a);
    ASSERT_EQ(real(saturate<Narrow>(a, count)), clamped);
    ASSERT_EQ(count, expected);
  });
  EXPECT_EQ(expected, 48U);
}

TEST(FixedPoint, SaturationOfNegativeValuesIntoUnsignedGivesZero) {
  using Narrow = Unsigned<2, Overflow::Saturate>;
  std::uint64_t count = 0;
  EXPECT_EQ(saturate<Narrow>(Small::fromRaw(-8), count).raw(), 0);
  EXPECT_EQ(saturate<Narrow>(Signed<9>::fromRaw(200), count).raw(), 3);
  EXPECT_EQ(count, 2U);
}

TEST(FixedPoint, RefusalEndsExactlyAtTheFormatsLimits) {
  using View = Fixed<18, 12, Sign::Signed, Rounding::TowardZero, Overflow::Refuse>;
  using Wide = Fixed<40, 34>;
  EXPECT_TRUE(fit<View>(Wide::fromRaw(131071)));
  EXPECT_FALSE(fit<View>(Wide::fromRaw(131072)));
  EXPECT_TRUE(fit<View>(Wide::fromRaw(-131072)));
  EXPECT_FALSE(fit<View>(Wide::fromRaw(-131073)));
}

}  // namespace
}  // namespace ipm_mapping::fpga

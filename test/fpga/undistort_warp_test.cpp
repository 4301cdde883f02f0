#include "ipm_mapping/fpga/undistort_warp.hpp"

#include <gtest/gtest.h>

#include "fpga/support.hpp"

namespace ipm_mapping::fpga {
namespace {

using formats::Generated;

std::optional<ViewPoint> project(const FrameParameters& p, int u, int v) {
  return Homography(p).project(Generated::fromRaw(u), Generated::fromRaw(v));
}

TEST(HomographyTwin, TruncatesTowardZeroOnBothSides) {
  FrameParameters p = test::identityParameters(64, 48);
  p.h31 = p.h32 = 0;
  p.h33 = 3 * 128;  // D = 3
  p.h11 = p.h12 = 0;
  p.h13 = -10 * 128;  // x = -10/3
  p.h21 = p.h22 = 0;
  p.h23 = 10 * 128;
  const auto point = project(p, 5, 7);
  ASSERT_TRUE(point);
  EXPECT_EQ(point->x.raw(), -213);  // -213.33 in 1/64
  EXPECT_EQ(point->y.raw(), 213);
}

TEST(HomographyTwin, TakesItsThirdColumnWithSevenFractionBits) {
  FrameParameters p = test::identityParameters(64, 48);
  p.h13 = 64;  // half a pixel
  p.h23 = -1;  // 1/128 px: half of the output's step
  const auto point = project(p, 10, 20);
  ASSERT_TRUE(point);
  EXPECT_EQ(point->x.raw(), 10 * 64 + 32);
  EXPECT_EQ(point->y.raw(), 20 * 64 - 1);  // 1279.5, truncated
}

TEST(HomographyTwin, RefusesDenominatorsThatAreNotPositive) {
  FrameParameters p = test::identityParameters(64, 48);
  p.h33 = 0;
  EXPECT_FALSE(project(p, 3, 3));
  p.h31 = 1;
  EXPECT_FALSE(project(p, 0, 0));
  p.h11 = p.h22 = 1;
  EXPECT_TRUE(project(p, 3, 3));
  p.h31 = -1;
  EXPECT_FALSE(project(p, 3, 3));
}

TEST(HomographyTwin, RefusesCoordinatesBeyondEighteenBits) {
  FrameParameters p = test::identityParameters(64, 48);
  p.h11 = p.h12 = p.h21 = p.h22 = 0;
  p.h31 = p.h32 = 0;
  p.h33 = 16;              // D = 1/8
  p.h13 = 2047 * 16 + 15;  // x = 2047.9375: 131068
  EXPECT_EQ(project(p, 0, 0)->x.raw(), 131068);
  p.h13 = 2048 * 16;
  EXPECT_FALSE(project(p, 0, 0));
  p.h13 = -2048 * 16;
  EXPECT_EQ(project(p, 0, 0)->x.raw(), -131072);
  p.h13 = -2048 * 16 - 1;
  EXPECT_FALSE(project(p, 0, 0));
}

TEST(HorizonTwin, ExcludesTheHorizonItselfAndCanBeSwitchedOff) {
  FrameParameters p = test::identityParameters(64, 48);
  p.horizon_a = 0;
  p.horizon_b = 16;
  p.horizon_c = -10;  // 16 v - 160
  const auto above = [&p](int v) {
    return Horizon(p).above(Generated::fromRaw(33), Generated::fromRaw(v));
  };
  EXPECT_TRUE(above(9));
  EXPECT_TRUE(above(10));
  EXPECT_FALSE(above(11));
  p.use_horizon = 0;
  EXPECT_FALSE(above(9));
}

/// Rule 4 written out in plain integers.
std::optional<std::pair<Integer, Integer>> lensByHand(const FrameParameters& p, Integer x,
                                                      Integer y, int& saturated) {
  const auto normalized = [&saturated](Integer n, Integer f) {
    const Integer q = n * 65536 / f;
    const Integer limited = std::min<Integer>(std::max<Integer>(q, -524288), 524287);
    saturated += limited != q;
    return limited;
  };
  const Integer xn = normalized(x - p.cx, p.fx), yn = normalized(y - p.cy, p.fy);
  const Integer r2 = (xn * xn + yn * yn) >> 16;
  if (r2 > p.r2_max) return std::nullopt;
  Integer q = p.k3 * 32;
  q = ((q * r2) >> 16) + p.k2 * 32;
  q = ((q * r2) >> 16) + p.k1 * 32;
  q = ((q * r2) >> 16) + 65536;
  return std::make_pair((((xn * q) >> 16) * p.fx >> 16) + p.cx,
                        (((yn * q) >> 16) * p.fy >> 16) + p.cy);
}

TEST(LensTwin, EqualsThePlainIntegerFormulaForAnyRegisters) {
  test::Generator random(4);
  int valid = 0, saturated = 0;
  for (int round = 0; round < 200000; ++round) {
    const FrameParameters p = round % 2 ? test::anyParameters(640, 480, random)
                                        : test::disturbedParameters(640, 480, random);
    const Integer x = test::between(random, -131072, 131071);
    const Integer y = test::between(random, -131072, 131071);
    std::uint64_t xn_count = 0, yn_count = 0;
    int expected_count = 0;
    const auto expected = lensByHand(p, x, y, expected_count);
    const auto actual =
        Lens(p).distort({formats::ViewCoordinate::fromRaw(x), formats::ViewCoordinate::fromRaw(y)},
                        xn_count, yn_count);
    ASSERT_EQ(actual.has_value(), expected.has_value());
    ASSERT_EQ(xn_count + yn_count, static_cast<std::uint64_t>(expected_count));
    saturated += expected_count;
    if (!expected) continue;
    ++valid;
    ASSERT_EQ(static_cast<Integer>(actual->u.raw()), expected->first);
    ASSERT_EQ(static_cast<Integer>(actual->v.raw()), expected->second);
  }
  EXPECT_GT(valid, 20000);
  EXPECT_GT(saturated, 20000);
}

TEST(AddressTwin, RoundsHalfUpAndEndsAtTheImageBorders) {
  const FrameParameters p = test::identityParameters(64, 48);
  const AddressGenerator address(p);
  const auto at = [&address](Integer u, Integer v) {
    return address.nearest({Lens::Distorted::fromRaw(u), Lens::Distorted::fromRaw(v)});
  };
  EXPECT_EQ(at(31, 0)->u, 0);
  EXPECT_EQ(at(32, 0)->u, 1);
  EXPECT_EQ(at(-32, 0)->u, 0);
  EXPECT_FALSE(at(-33, 0));
  EXPECT_EQ(at(63 * 64 + 31, 0)->u, 63);
  EXPECT_FALSE(at(63 * 64 + 32, 0));
  EXPECT_EQ(at(0, 47 * 64 + 31)->v, 47);
  EXPECT_FALSE(at(0, 47 * 64 + 32));
  EXPECT_FALSE(at(Integer{1} << 40, 0));
}

TEST(AddressTwin, WrapsInTheRingAndStaysWithinNineteenBits) {
  FrameParameters p = test::driveParameters(640, 480);
  const AddressGenerator address(p);
  EXPECT_EQ(address.memory(0, {5, 2}).raw(), 2 * 640 + 5);
  EXPECT_EQ(address.memory(818, {639, 1}).raw(), 639);
  EXPECT_LE(address.memory(400, {639, 418}).raw(), formats::Address::highest());
}

TEST(AddressTwin, CountsReadsLessThanFiftyRowsAheadOfTheWrite) {
  FrameParameters p = test::driveParameters(640, 480);
  p.memory_rows = 480 + 100;
  const AddressGenerator address(p);
  EXPECT_FALSE(address.readsNearWrite(99, {0, 0}));
  EXPECT_TRUE(address.readsNearWrite(100, {0, 49}));
  EXPECT_FALSE(address.readsNearWrite(100, {0, 50}));
  EXPECT_TRUE(address.readsNearWrite(110, {0, 59}));
  EXPECT_FALSE(address.readsNearWrite(110, {0, 60}));
  EXPECT_TRUE(address.readsNearWrite(200, {0, 3}));  // overwritten already
}

TEST(UndistortWarpTwin, CountsSaturationsOnlyOfPixelsStillInUse) {
  FrameParameters p = test::identityParameters(64, 48);
  p.fx = p.fy = 64;  // one pixel: xn of the outer columns leaves 20 bits
  p.horizon_b = 16;
  p.horizon_c = -20;  // rows up to 20 are above the horizon
  OverflowCounters counters;
  UndistortWarp warp(p);
  (void)warp.reference(0, 10, counters);
  EXPECT_EQ(counters[Wire::Xn], 0U);
  (void)warp.reference(0, 30, counters);
  EXPECT_EQ(counters[Wire::Xn], 1U);
  EXPECT_EQ(counters[Wire::Yn], 0U);
  (void)warp.current(0, 10, counters);  // the current path has no horizon
  EXPECT_EQ(counters[Wire::XnCurrent], 1U);
  EXPECT_EQ(counters[Wire::YnCurrent], 1U);
}

TEST(UndistortWarpTwin, PaperOrderCountsEveryPixelOnTheReferencePath) {
  FrameParameters p = test::identityParameters(64, 48);
  p.fx = p.fy = 64;
  p.horizon_c = -1;  // nothing is floor
  p.paper_order = 1;
  OverflowCounters counters;
  UndistortWarp warp(p);
  EXPECT_FALSE(warp.reference(0, 10, counters));
  EXPECT_EQ(counters[Wire::Xn], 1U);
}

TEST(UndistortWarpTwin, BothOrdersAgreeWithoutDistortionAndWithoutMotion) {
  FrameParameters p = test::identityParameters(64, 48);
  OverflowCounters counters;
  FrameParameters paper = p;
  paper.paper_order = 1;
  for (int v = 0; v < 48; ++v) {
    for (int u = 0; u < 64; ++u) {
      const auto a = UndistortWarp(p).reference(u, v, counters);
      const auto b = UndistortWarp(paper).reference(u, v, counters);
      ASSERT_TRUE(a && b);
      ASSERT_EQ(a->u, u);
      ASSERT_EQ(b->v, v);
    }
  }
}

TEST(UndistortWarpTwin, RawCurrentStreamIsTakenAsItComes) {
  FrameParameters p = test::driveParameters(640, 480);
  p.undistort_current = 0;
  OverflowCounters counters;
  const auto pixel = UndistortWarp(p).current(3, 477, counters);
  EXPECT_EQ(pixel->u, 3);
  EXPECT_EQ(pixel->v, 477);
  p.undistort_current = 1;
  const auto bent = UndistortWarp(p).current(320, 400, counters);
  ASSERT_TRUE(bent);
  EXPECT_NE(bent->v, 400);
}

}  // namespace
}  // namespace ipm_mapping::fpga

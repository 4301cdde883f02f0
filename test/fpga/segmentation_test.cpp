#include <gtest/gtest.h>

#include "fpga/support.hpp"
#include "ipm_mapping/fpga/difference.hpp"
#include "ipm_mapping/fpga/erosion.hpp"
#include "ipm_mapping/fpga/gaussian.hpp"
#include "ipm_mapping/fpga/otsu.hpp"

namespace ipm_mapping::fpga {
namespace {

TEST(DifferenceTwin, IsTheMagnitudeForEveryPairOfPixels) {
  for (int a = 0; a < 256; ++a) {
    for (int b = 0; b < 256; ++b) {
      ASSERT_EQ(absoluteDifference(static_cast<std::uint8_t>(a), static_cast<std::uint8_t>(b)),
                std::abs(a - b));
    }
  }
}

TEST(DifferenceTwin, SaysNoCorrespondenceOutsideEitherFrame) {
  OwnedInputs owned;
  owned.parameters = test::identityParameters(20, 16);
  owned.parameters.h13 = 5 * 128;  // the reference is sampled 5 px to the right
  owned.reference.resize(20, 16, 200);
  owned.current.resize(20, 16, 90);
  Image<TaggedPixel> out(20, 16);
  OverflowCounters counters;
  difference(owned.inputs(), out.view(), counters);
  EXPECT_EQ(out.at(14, 3), 110);
  EXPECT_EQ(out.at(15, 3), no_correspondence);
}

/// Rule 8 written out.
TaggedPixel convolveByHand(const Image<TaggedPixel>& in, int u, int v) {
  int sum = 0;
  for (int dv = -1; dv <= 1; ++dv) {
    for (int du = -1; du <= 1; ++du) {
      const int value = in.at(u + du, v + dv) == no_correspondence ? 0 : in.at(u + du, v + dv);
      sum += value >> (2 + std::abs(du) + std::abs(dv));
    }
  }
  return static_cast<TaggedPixel>(sum);
}

TEST(GaussianTwin, ShiftsEveryTermBeforeTheSum) {
  test::Generator random(8);
  Image<TaggedPixel> in(33, 21), out(33, 21);
  for (int v = 0; v < 21; ++v) {
    for (int u = 0; u < 33; ++u) {
      const Integer pixel = test::between(random, 0, 300);
      in.at(u, v) = pixel > 255 ? no_correspondence : static_cast<TaggedPixel>(pixel);
    }
  }
  gaussian(std::as_const(in).view(), out.view());
  for (int v = 0; v < 21; ++v) {
    for (int u = 0; u < 33; ++u) {
      const bool border = u == 0 || v == 0 || u == 32 || v == 20;
      const bool invalid = border || in.at(u, v) == no_correspondence;
      ASSERT_EQ(out.at(u, v), invalid ? no_correspondence : convolveByHand(in, u, v));
    }
  }
}

TEST(GaussianTwin, LosesAtMostEightGreyLevelsOnAFlatImage) {
  Image<TaggedPixel> out(5, 5);
  int worst = 0, total = 0;
  for (int grey = 0; grey < 256; ++grey) {
    const Image<TaggedPixel> in(5, 5, static_cast<TaggedPixel>(grey));
    gaussian(in.view(), out.view());
    worst = std::max(worst, grey - out.at(2, 2));
    total += grey - out.at(2, 2);
  }
  EXPECT_EQ(worst, 8);
  EXPECT_NEAR(total / 256.0, 4.0, 1.6);
}

TEST(GaussianTwin, NeverReachesTheFastEnginesInvalidMarker) {
  Image<TaggedPixel> out(3, 3);
  gaussian(Image<TaggedPixel>(3, 3, 255).view(), out.view());
  EXPECT_EQ(out.at(1, 1), 247);
}

TEST(GaussianTwin, AnImageWithoutInteriorHasNoCorrespondence) {
  Image<TaggedPixel> out(2, 2);
  gaussian(Image<TaggedPixel>(2, 2, 9).view(), out.view());
  EXPECT_EQ(out.at(1, 1), no_correspondence);
}

GreyHistogram bins(std::initializer_list<std::pair<int, std::uint32_t>> entries) {
  GreyHistogram all{};
  for (const auto& [grey, count] : entries) all[static_cast<std::size_t>(grey)] = count;
  return all;
}

TEST(OtsuTwin, FirstOfEqualMaximaWins) {
  // Every k in 10 ... 199 gives the same split.
  EXPECT_EQ(otsuThreshold(bins({{10, 500}, {200, 300}})), 10);
}

TEST(OtsuTwin, KeepsSilentWithoutTwoClasses) {
  EXPECT_EQ(otsuThreshold(bins({})), std::nullopt);
  EXPECT_EQ(otsuThreshold(bins({{77, 1000}})), std::nullopt);
}

TEST(OtsuTwin, HoldsTheLargestVarianceInItsRegister) {
  // Half black, half white at VGA: sigma^2 = 153600^2 * 255^2, just below 2^51.
  EXPECT_EQ(otsuThreshold(bins({{0, 153600}, {255, 153600}})), 0);
  EXPECT_LT(153600.0 * 153600.0 * 255.0 * 255.0, std::ldexp(1.0, 51));
}

TEST(OtsuTwin, IntegerMeansCanMoveTheThreshold) {
  // Real means are best split at 1 (48 against 38.4 and 36.6), truncated ones at 2.
  const GreyHistogram all = bins({{0, 3}, {1, 3}, {2, 1}, {3, 1}});
  Integer best = 0;
  int expected = -1;
  for (int k = 0; k < 256; ++k) {
    Integer w0 = 0, s0 = 0, w1 = 0, s1 = 0;
    for (int g = 0; g < 256; ++g) {
      (g <= k ? w0 : w1) += all[static_cast<std::size_t>(g)];
      (g <= k ? s0 : s1) += g * Integer{all[static_cast<std::size_t>(g)]};
    }
    if (!w0 || !w1) continue;
    const Integer step = s1 / w1 - s0 / w0;
    if (w0 * w1 * step * step > best) best = w0 * w1 * step * step, expected = k;
  }
  EXPECT_EQ(otsuThreshold(all), expected);
  EXPECT_EQ(expected, 2);
}

TEST(OtsuTwin, MaskIsStrictlyAboveTheHigherOfRegisterAndMinimum) {
  EXPECT_EQ(maskThreshold(3, 6), 6);
  EXPECT_EQ(maskThreshold(9, 6), 9);
  Image<TaggedPixel> in(3, 1);
  in.at(0, 0) = 9;
  in.at(1, 0) = 10;
  in.at(2, 0) = no_correspondence;
  Image<std::uint8_t> mask(3, 1);
  binarise(std::as_const(in).view(), 9, mask.view());
  EXPECT_EQ(mask.at(0, 0), 0);
  EXPECT_EQ(mask.at(1, 0), 1);
  EXPECT_EQ(mask.at(2, 0), 0);
}

TEST(OtsuTwin, RegisterStartsAndResetsAtWhite) {
  ThresholdRegister threshold;
  EXPECT_EQ(threshold.value(), 255);
  threshold.load(31);
  EXPECT_EQ(threshold.value(), 31);
  threshold.reset();
  EXPECT_EQ(threshold.value(), 255);
}

TEST(OtsuTwin, ThisFramesThresholdServesTheNextFrameOnly) {
  test::Generator random(5);
  OwnedInputs owned;
  test::paintFrame(owned.reference, 80, 60, random);
  test::paintFrame(owned.current, 80, 60, random);
  owned.parameters = test::identityParameters(80, 60);
  owned.parameters.threshold_in = 255;
  Wires wires;
  runAllWires(owned.inputs(), wires);
  ASSERT_LT(wires.results.threshold_out, 255);
  int ones = 0;
  for (int v = 0; v < 60; ++v) {
    for (int u = 0; u < 80; ++u) ones += wires.mask.at(u, v);
  }
  EXPECT_EQ(ones, 0);
}

TEST(ErosionTwin, KeepsOnlyPixelsWithAllNeighboursAndClearsTheBorder) {
  Image<std::uint8_t> mask(7, 6, 1), out(7, 6);
  mask.at(2, 2) = 0;
  erosion(std::as_const(mask).view(), out.view());
  for (int v = 0; v < 6; ++v) {
    for (int u = 0; u < 7; ++u) {
      const bool border = u == 0 || v == 0 || u == 6 || v == 5;
      const bool near = std::abs(u - 2) <= 1 && std::abs(v - 2) <= 1;
      ASSERT_EQ(out.at(u, v), border || near ? 0 : 1) << u << ' ' << v;
    }
  }
}

}  // namespace
}  // namespace ipm_mapping::fpga

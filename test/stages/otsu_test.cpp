#include "ipm_mapping/stages/otsu.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "support/pictures.hpp"

namespace ipm_mapping::test {
namespace {

using Wide = __int128;

/// Eq. 3.30 in exact integers: the between-class variance is
/// (w1 S0 - w0 S1)^2 / (w0 w1), compared as fractions. -1 where no k leaves two classes.
int exactOtsu(const Histogram& histogram) {
  int best = -1;
  Wide best_numerator = 0, best_denominator = 1;
  for (int k = 0; k < 256; ++k) {
    Wide w0 = 0, w1 = 0, s0 = 0, s1 = 0;
    for (int grey = 0; grey < 256; ++grey) {
      const Wide count = histogram[static_cast<std::size_t>(grey)];
      (grey <= k ? w0 : w1) += count;
      (grey <= k ? s0 : s1) += count * grey;
    }
    if (w0 == 0 || w1 == 0) continue;
    const Wide root = w1 * s0 - w0 * s1;
    const Wide numerator = root * root, denominator = w0 * w1;
    if (numerator * best_denominator > best_numerator * denominator) {
      best = k;
      best_numerator = numerator;
      best_denominator = denominator;
    }
  }
  return best;
}

int thresholdOf(const Histogram& histogram) {
  const auto found = otsu(histogram);
  return found ? found->threshold : -1;
}

/// Two bell-shaped classes.
Picture bimodal(std::mt19937& random, double low, double high, double share) {
  std::normal_distribution<double> spread(0.0, 12.0);
  Picture picture(160, 120);
  for (int v = 0; v < 120; ++v) {
    for (int u = 0; u < 160; ++u) {
      const double grey = (draw(random, 0.0, 1.0) < share ? high : low) + spread(random);
      picture(u, v) = cv::saturate_cast<std::uint8_t>(grey);
    }
  }
  return picture;
}

TEST(Otsu, EqualsOpenCvOnFullyValidPictures) {
  std::mt19937 random(4);
  for (int round = 0; round < 40; ++round) {
    Picture picture = bimodal(random, draw(random, 10.0, 100.0), draw(random, 60.0, 240.0),
                              draw(random, 0.01, 0.99));
    const Picture valid(160, 120, 255);
    cv::Mat binary;
    const double expected =
        cv::threshold(picture.mat(), binary, 0, 255, cv::THRESH_BINARY | cv::THRESH_OTSU);
    EXPECT_EQ(thresholdOf(histogramOf(picture.view(), valid.view())), expected) << round;
  }
}

TEST(Otsu, FindsTheFirstExactMaximumOfEverySmallHistogram) {
  // Small counts on a few levels: exact ties abound.
  constexpr std::array<std::size_t, 5> level{0, 1, 100, 200, 255};
  for (unsigned code = 0; code < 7U * 7U * 7U * 7U * 7U; ++code) {
    Histogram histogram{};
    for (unsigned rest = code, i = 0; i < level.size(); ++i, rest /= 7)
      histogram[level[i]] = rest % 7;
    ASSERT_EQ(thresholdOf(histogram), exactOtsu(histogram)) << "histogram " << code;
  }
}

TEST(Otsu, FindsTheFirstExactMaximumOfRandomHistogramsUpToVga) {
  std::mt19937 random(5);
  for (int round = 0; round < 300; ++round) {
    Histogram histogram{};
    const int bins = draw(random, 1, 256), highest = 1 << draw(random, 0, 10);
    for (int i = 0; i < bins; ++i)
      histogram[static_cast<std::size_t>(draw(random, 0, 255))] =
          static_cast<std::uint32_t>(draw(random, 0, highest));
    ASSERT_EQ(thresholdOf(histogram), exactOtsu(histogram)) << round;
  }
}

TEST(Otsu, TakesTheFirstOfAPlateauBetweenTwoLevels) {
  Histogram histogram{};
  histogram[50] = histogram[200] = 10;
  EXPECT_EQ(thresholdOf(histogram), 50);
}

TEST(Otsu, FindsNothingInOneLevelOrNone) {
  Histogram histogram{};
  EXPECT_FALSE(otsu(histogram));
  histogram[255] = 1;
  EXPECT_FALSE(otsu(histogram));
  histogram = {};
  histogram[0] = 307200;
  EXPECT_FALSE(otsu(histogram));
}

TEST(Otsu, SeparabilityIsTheBetweenClassShareOfTheVariance) {
  std::mt19937 random(6);
  const Picture picture = bimodal(random, 40, 90, 0.2);
  const Picture valid(160, 120, 255);
  const auto found = otsu(histogramOf(picture.view(), valid.view()));
  ASSERT_TRUE(found);
  double n[2] = {}, sum[2] = {}, squares = 0.0;
  for (int v = 0; v < 120; ++v) {
    for (int u = 0; u < 160; ++u) {
      const int grey = picture(u, v), label = grey > found->threshold;
      n[label] += 1;
      sum[label] += grey;
      squares += grey * grey;
    }
  }
  const double all = n[0] + n[1], mean = (sum[0] + sum[1]) / all;
  const double total = squares / all - mean * mean;
  const double gap = sum[1] / n[1] - sum[0] / n[0];
  EXPECT_NEAR(found->separability, n[0] * n[1] / (all * all) * gap * gap / total, 1e-12);
}

TEST(Otsu, SeparabilityIsOneForTwoLevelsAndLowForNoise) {
  Histogram histogram{};
  histogram[3] = 90;
  histogram[120] = 7;
  EXPECT_NEAR(otsu(histogram)->separability, 1.0, 1e-12);
  histogram = {};
  for (std::size_t k = 0; k < 256; ++k) histogram[k] = 1200;
  EXPECT_NEAR(otsu(histogram)->separability, 0.75, 1e-4);  // uniform: 3/4
}

TEST(Histogram, CountsValidPixelsOnlyAtEverySize) {
  std::mt19937 random(7);
  for (const cv::Size size : awkwardSizes()) {
    Picture image = noise(size.width, size.height, random, 0, 5);
    const Picture valid = speckle(size.width, size.height, random, 0.6);
    Histogram expected{};
    for (int v = 0; v < size.height; ++v)
      for (int u = 0; u < size.width; ++u)
        if (!valid(u, v)) image(u, v) = 0;
    for (int v = 0; v < size.height; ++v)
      for (int u = 0; u < size.width; ++u)
        if (valid(u, v)) ++expected[image(u, v)];
    EXPECT_EQ(histogramOf(image.view(), valid.view()), expected) << size;
  }
}

TEST(Histogram, HoldsAFlatPictureOfVgaSize) {
  const Picture image(640, 480, 17), valid(640, 480, 255);
  const Histogram histogram = histogramOf(image.view(), valid.view());
  EXPECT_EQ(histogram[17], 640U * 480U);
  EXPECT_EQ(histogram[0] + histogram[16] + histogram[18], 0U);
}

TEST(Binarize, IsTrueAboveTheThresholdWhereValid) {
  std::mt19937 random(8);
  for (const int threshold : {0, 6, 127, 254, 255}) {
    for (const cv::Size size : awkwardSizes()) {
      const Picture image = noise(size.width, size.height, random);
      const Picture valid = speckle(size.width, size.height, random, 0.8);
      Picture binary(size.width, size.height, 3), expected(size.width, size.height);
      for (int v = 0; v < size.height; ++v)
        for (int u = 0; u < size.width; ++u)
          expected(u, v) = valid(u, v) != 0 && image(u, v) > threshold ? 255 : 0;
      binarize(image.view(), valid.view(), threshold, binary.view());
      EXPECT_TRUE(equal(binary, expected)) << size << " threshold " << threshold;
    }
  }
}

}  // namespace
}  // namespace ipm_mapping::test

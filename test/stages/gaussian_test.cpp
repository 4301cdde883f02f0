#include "ipm_mapping/stages/gaussian.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "support/pictures.hpp"

namespace ipm_mapping::test {
namespace {

/// The definition: nine weighted pixels, invalid ones hold 0, rounded half up.
int blurredAt(const Picture& image, int u, int v) {
  static constexpr int weight[3][3] = {{1, 2, 1}, {2, 4, 2}, {1, 2, 1}};
  int sum = 0;
  for (int dv = -1; dv <= 1; ++dv)
    for (int du = -1; du <= 1; ++du) sum += weight[dv + 1][du + 1] * image(u + du, v + dv);
  return (sum + 8) / 16;
}

struct Expected {
  Picture blurred, valid;
};

Expected slowGaussian(const Picture& image, const Picture& valid) {
  const int W = image.width(), H = image.height();
  Expected e{Picture(W, H), Picture(W, H)};
  for (int v = 1; v < H - 1; ++v) {
    for (int u = 1; u < W - 1; ++u) {
      if (valid(u, v) == 0) continue;
      e.valid(u, v) = 255;
      e.blurred(u, v) = static_cast<std::uint8_t>(blurredAt(image, u, v));
    }
  }
  return e;
}

TEST(Gaussian, EqualsOpenCvInsideAValidPicture) {
  std::mt19937 random(2);
  Picture image = noise(203, 41, random), valid(203, 41, 255);
  Picture blurred(203, 41), blurred_valid(203, 41), expected(203, 41);
  Gaussian()(image.view(), valid.view(), blurred.view(), blurred_valid.view());
  cv::GaussianBlur(image.mat(), expected.mat(), {3, 3}, 0);
  const cv::Rect inside(1, 1, 201, 39);
  EXPECT_EQ(cv::norm(blurred.mat()(inside), expected.mat()(inside), cv::NORM_INF), 0.0);
}

TEST(Gaussian, EqualsTheDefinitionAroundInvalidPixelsAndBordersAtEverySize) {
  std::mt19937 random(3);
  Gaussian gaussian;  // one workspace for every size
  for (const cv::Size size : awkwardSizes()) {
    Picture image = noise(size.width, size.height, random);
    const Picture valid = speckle(size.width, size.height, random, 0.8);
    for (int v = 0; v < size.height; ++v)
      for (int u = 0; u < size.width; ++u)
        if (valid(u, v) == 0) image(u, v) = 0;
    Picture blurred(size.width, size.height, 9), blurred_valid(size.width, size.height, 9);
    gaussian(image.view(), valid.view(), blurred.view(), blurred_valid.view());
    const Expected expected = slowGaussian(image, valid);
    EXPECT_TRUE(equal(blurred, expected.blurred)) << size;
    EXPECT_TRUE(equal(blurred_valid, expected.valid)) << size;
  }
}

TEST(Gaussian, KeepsTheBrightestLevel) {
  Picture image(5, 5, 255), valid(5, 5, 255), blurred(5, 5), blurred_valid(5, 5);
  Gaussian()(image.view(), valid.view(), blurred.view(), blurred_valid.view());
  EXPECT_EQ(blurred(2, 2), 255);
  EXPECT_EQ(blurred(1, 3), 255);
}

TEST(Gaussian, RoundsHalvesUp) {
  Picture image(3, 3), valid(3, 3, 255), blurred(3, 3), blurred_valid(3, 3);
  image(0, 0) = 8;  // weight 1: 8/16
  Gaussian()(image.view(), valid.view(), blurred.view(), blurred_valid.view());
  EXPECT_EQ(blurred(1, 1), 1);
  image(0, 0) = 7;
  Gaussian()(image.view(), valid.view(), blurred.view(), blurred_valid.view());
  EXPECT_EQ(blurred(1, 1), 0);
}

}  // namespace
}  // namespace ipm_mapping::test

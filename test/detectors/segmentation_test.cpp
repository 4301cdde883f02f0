#include "ipm_mapping/detectors/segmentation.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "ipm_mapping/parameters.hpp"
#include "support/pictures.hpp"

namespace ipm_mapping::test {
namespace {

constexpr int W = 100, H = 80;

/// Dim noise with a bright square of side 21 in the middle.
Picture square(std::mt19937& random, int bright) {
  Picture picture = noise(W, H, random, 0, 3);
  for (int v = 30; v <= 50; ++v)
    for (int u = 40; u <= 60; ++u) picture(u, v) = static_cast<std::uint8_t>(bright);
  return picture;
}

int obstaclePixels(const Picture& mask) {
  int n = 0;
  for (int v = 0; v < H; ++v)
    for (int u = 0; u < W; ++u) n += mask(u, v) == mask::obstacle;
  return n;
}

struct Segmented {
  Segmentation::Result result;
  int obstacle_pixels;
};
Segmented run(Segmentation& segmentation, const Picture& difference, const Picture& valid) {
  Picture mask(W, H);
  const Segmentation::Result result =
      segmentation.process(difference.view(), valid.view(), mask.view());
  EXPECT_TRUE(mask.guarded());
  return {result, obstaclePixels(mask)};
}

TEST(Segmentation, EqualsOpenCvStageByStage) {
  std::mt19937 random(40);
  Picture difference = square(random, 90), valid(W, H, 255), mask(W, H);
  Segmentation segmentation;
  const auto result = segmentation.process(difference.view(), valid.view(), mask.view());
  cv::Mat blurred, binary, eroded;
  cv::GaussianBlur(difference.mat(), blurred, {3, 3}, 0);
  const cv::Rect inside(1, 1, W - 2, H - 2);
  const double threshold =
      cv::threshold(blurred(inside), binary, 0, 255, cv::THRESH_BINARY | cv::THRESH_OTSU);
  cv::erode(binary, eroded, cv::Mat::ones(3, 3, CV_8U), {-1, -1}, 1, cv::BORDER_CONSTANT, 0);
  EXPECT_EQ(result.threshold, std::max(static_cast<int>(threshold), 6));
  cv::Mat found = mask.mat()(inside) == mask::obstacle;
  EXPECT_EQ(cv::norm(found, eroded, cv::NORM_INF), 0.0);
  EXPECT_GT(cv::countNonZero(found), 300);
}

TEST(Segmentation, BorderAndInvalidPixelsAreUnseen) {
  std::mt19937 random(41);
  Picture difference = square(random, 90), valid(W, H, 255), mask(W, H);
  for (int v = 0; v < H; ++v) valid(10, v) = difference(10, v) = 0;
  Segmentation().process(difference.view(), valid.view(), mask.view());
  for (int v = 0; v < H; ++v) {
    for (int u = 0; u < W; ++u) {
      const bool unseen = u == 0 || v == 0 || u == W - 1 || v == H - 1 || u == 10;
      EXPECT_EQ(mask(u, v) == mask::unseen, unseen) << u << " " << v;
    }
  }
}

TEST(Segmentation, ThresholdIsNeverBelowTheFloor) {
  std::mt19937 random(42);
  Segmentation segmentation;
  EXPECT_EQ(run(segmentation, square(random, 7), Picture(W, H, 255)).result.threshold, 6);
}

TEST(Segmentation, NoiseWithoutTwoClassesHasNoObstaclePixels) {
  std::mt19937 random(43);
  const Picture valid(W, H, 255);
  Picture flat(W, H, 120);
  Segmentation guarded;
  EXPECT_EQ(run(guarded, flat, valid).obstacle_pixels, 0);
  // The mean of many levels: a bell without two classes, bright enough to pass the threshold.
  Picture bell = noise(W, H, random, 0, 255);
  cv::GaussianBlur(bell.mat(), bell.mat(), {9, 9}, 0);
  SegmentationParameters strict;
  strict.min_separability = 0.8;
  Segmentation separable(strict);
  const Segmented quiet = run(separable, bell, valid);
  EXPECT_EQ(quiet.obstacle_pixels, 0);
  EXPECT_LT(quiet.result.separability, 0.8F);
  strict.min_separability = 0.0;
  separable.setParameters(strict);
  EXPECT_GT(run(separable, bell, valid).obstacle_pixels, 100);
}

TEST(Segmentation, PaperUsesTheThresholdOfTheFrameBefore) {
  std::mt19937 random(44);
  const Picture valid(W, H, 255);
  const Picture dim = square(random, 60), bright = square(random, 240);
  Segmentation paper(Parameters::profile("paper").segmentation), now;
  const int of_dim = run(now, dim, valid).result.threshold;
  EXPECT_EQ(run(paper, dim, valid).result.threshold, 255);
  EXPECT_EQ(run(paper, bright, valid).result.threshold, run(now, dim, valid).result.threshold);
  const int of_bright = run(now, bright, valid).result.threshold;
  EXPECT_EQ(run(paper, dim, valid).result.threshold, of_bright);
  EXPECT_NE(of_dim, of_bright);
  paper.reset();
  EXPECT_EQ(run(paper, dim, valid).result.threshold, 255);
}

TEST(Segmentation, ThresholdSurvivesAFrameWithoutTwoClasses) {
  std::mt19937 random(45);
  const Picture valid(W, H, 255), nothing(W, H, 0);
  Segmentation paper(Parameters::profile("paper").segmentation);
  run(paper, square(random, 100), valid);
  const int kept = run(paper, nothing, valid).result.threshold;
  EXPECT_LT(kept, 100);
  EXPECT_EQ(run(paper, nothing, valid).result.threshold, kept);
  EXPECT_EQ(run(paper, nothing, Picture(W, H, 0)).result.threshold, kept);
}

}  // namespace
}  // namespace ipm_mapping::test

#include <gtest/gtest.h>

#include <cmath>

#include "fpga/support.hpp"
#include "ipm_mapping/fpga/radial_histogram.hpp"

namespace ipm_mapping::fpga {
namespace {

GroundView view(double pitch, double height) {
  GroundView v;
  v.camera = CameraModel({640, 480, 525, 525, 319.5, 239.5}, {});
  v.T_base_camera = cameraPose(0.1, 0.0, height, pitch);
  v.motion = {0.1, 0.01, 0.03};
  return v;
}

/// Greatest distance between the twin's coordinate and the exact one, over output pixels whose
/// exact one is seen.
double worstError(const BirdsEyeGeometry& geometry, BirdsEyePrecision precision) {
  const auto words = quantiseBirdsEye(geometry, precision);
  EXPECT_TRUE(words);
  double worst = 0.0;
  for (int v = 0; v < 480; v += 7) {
    for (int u = 0; u < 640; u += 7) {
      const Eigen::Vector3d p = geometry.to_view * Eigen::Vector3d(u, v, 1);
      if (!(p.z() > 0.0)) continue;
      const Eigen::Vector2d exact = p.hnormalized();
      if (exact.x() < 0 || exact.y() < 0 || exact.x() > 639 || exact.y() > 479) continue;
      const auto point = birdsEyePoint(*words, u, v);
      if (!point) return std::numeric_limits<double>::infinity();
      worst = std::max(worst, (Eigen::Vector2d(point->x, point->y) / 64.0 - exact).norm());
    }
  }
  return worst;
}

TEST(BirdsEyeTwin, FourteenFractionBitsAreNotEnoughAndTwentyAre) {
  for (const double pitch : {0.25, 0.35, 0.5}) {
    for (const double height : {0.25, 0.4}) {
      const auto geometry = BirdsEyeGeometry::over(view(pitch, height), 4.0);
      const double source = worstError(geometry, BirdsEyePrecision::Source14);
      const double wide = worstError(geometry, BirdsEyePrecision::Wide20);
      EXPECT_GT(source, 2.0) << pitch << ' ' << height;
      EXPECT_LT(wide, 1.0) << pitch << ' ' << height;
    }
  }
}

TEST(BirdsEyeTwin, TheFloorAheadLiesAboveTheCentreAtItsScale) {
  const GroundView v = view(0.35, 0.3);
  const auto geometry = BirdsEyeGeometry::over(v, 4.0);
  EXPECT_DOUBLE_EQ(geometry.metres_per_pixel, 4.0 / 640);
  // 1 m ahead of the mid foot point is 160 px above the principal point.
  const Eigen::Vector2d floor = geometry.mid_foot + Eigen::Vector2d(1.0, 0.0);
  const Eigen::Vector2d expected = *v.currentFloor().pixel(floor);
  const auto words = quantiseBirdsEye(geometry, BirdsEyePrecision::Wide20);
  const auto left = birdsEyePoint(*words, 319, 79), right = birdsEyePoint(*words, 320, 80);
  ASSERT_TRUE(left && right);
  EXPECT_NEAR((left->x + right->x) / 128.0, expected.x(), 1.0);
  EXPECT_NEAR((left->y + right->y) / 128.0, expected.y(), 1.0);
}

TEST(BirdsEyeTwin, OutsideTheViewIsUnseen) {
  const auto geometry = BirdsEyeGeometry::over(view(0.35, 0.3), 4.0);
  const auto words = quantiseBirdsEye(geometry, BirdsEyePrecision::Wide20);
  const Image<std::uint8_t> eroded(640, 480, 1);
  Image<std::uint8_t> out(640, 480);
  birdsEyeView(*words, eroded.view(), out.view());
  EXPECT_EQ(out.at(320, 470), birds_eye_unseen);  // behind the camera
  EXPECT_EQ(out.at(320, 100), 1);
}

TEST(RadialHistogramTwin, RootIsExactForEveryPixelOfTheView) {
  for (int dv = 0; dv < 480; ++dv) {
    for (int du = 0; du < 640; ++du) {
      ASSERT_EQ(radiusOf(-du, dv), static_cast<int>(std::sqrt(du * du + dv * dv)));
    }
  }
}

TEST(RadialHistogramTwin, SectorReachesDownToHalfThePeak) {
  PolarHistogram bear{};
  bear[9] = 49;
  bear[10] = 50;
  bear[11] = 100;
  bear[12] = 60;
  bear[13] = 49;
  const PeakSector sector = peakSector(bear, 11);
  EXPECT_EQ(sector.first, 10);
  EXPECT_EQ(sector.last, 12);
}

/// A bird's-eye view with a block between two radii straight ahead.
Image<std::uint8_t> blockAhead(int near, int far) {
  Image<std::uint8_t> image(640, 480, 0);
  for (int v = 240 - far; v <= 240 - near; ++v) {
    for (int u = 300; u <= 340; ++u) image.at(u, v) = 1;
  }
  return image;
}

TEST(RadialHistogramTwin, DistanceIsTheNearestRadiusThatIsMostlyObstacle) {
  const FrameParameters p = test::driveParameters(640, 480);
  FirstArchitecture architecture;
  FirstArchitectureResults results;
  const Image<std::uint8_t> image = blockAhead(90, 200);
  architecture.run(image.view(), {320, 240}, p, results);
  ASSERT_GE(results.peaks.size, 1);
  EXPECT_NEAR(results.radius[0], 90, 1);
}

TEST(RadialHistogramTwin, UnseenPixelsDoNotDiluteARadius) {
  const FrameParameters p = test::driveParameters(640, 480);
  Image<std::uint8_t> image = blockAhead(90, 200);
  for (int v = 0; v < 480; ++v) {
    for (int u = 0; u < 640; ++u) {
      if (image.at(u, v) == 0 && v > 100) image.at(u, v) = birds_eye_unseen;
    }
  }
  FirstArchitecture strict(255);
  FirstArchitectureResults results;
  strict.run(std::as_const(image).view(), {320, 240}, p, results);
  ASSERT_GE(results.peaks.size, 1);
  EXPECT_NEAR(results.radius[0], 90, 1);
}

TEST(RadialHistogramTwin, AnEmptyViewHasNoPeaks) {
  FirstArchitecture architecture;
  FirstArchitectureResults results;
  const Image<std::uint8_t> empty(640, 480, 0);
  architecture.run(empty.view(), {320, 240}, test::driveParameters(640, 480), results);
  EXPECT_EQ(results.peaks.size, 0);
  EXPECT_EQ(results.radius[0], -1);
}

}  // namespace
}  // namespace ipm_mapping::fpga

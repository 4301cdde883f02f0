#include "ipm_mapping/view/overlay.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace ipm_mapping {
namespace {

constexpr int width = 320, height = 240, enlarged = 4;

GroundView viewOf(double pitch = 0.42) {
  GroundView view;
  view.camera = CameraModel({width, height, 260, 260, 159.5, 119.5}, {});
  view.T_base_camera = cameraPose(0.05, 0.0, 0.45, pitch);
  view.motion = {0.1, 0.0, 0.0};
  return view;
}

/// One bearing straight ahead, 20 degrees wide between two that say nothing.
Obstacles straightAhead(BearingState state, float range) {
  Obstacles o;
  o.view = viewOf();
  o.focus = midFootFocus(vanishingPoints(o.view));
  o.max_range = 2.0;
  for (const float angle : {0.35F, 0.0F, -0.35F}) {
    Bearing b;
    b.angle = angle;
    b.range = range;
    b.near = 0.4F;
    b.state = angle == 0.0F ? state : BearingState::Unknown;
    o.bearings.push_back(b);
  }
  return o;
}

/// Colour of the overlay at a floor point of base.
cv::Vec3b colorAt(const cv::Mat& overlay, const Obstacles& o, double x, double y) {
  const Eigen::Vector2d p = *o.view.currentFloor().pixel({x, y});
  return overlay.at<cv::Vec3b>(static_cast<int>(std::lround((p.y() + 0.5) * enlarged)),
                               static_cast<int>(std::lround((p.x() + 0.5) * enlarged)));
}
bool isGreen(const cv::Vec3b& c) { return c[1] > c[2] + 20 && c[1] > c[0] + 10; }
bool isAmber(const cv::Vec3b& c) { return c[2] > c[0] + 40 && c[1] > c[0] + 20; }
bool isGray(const cv::Vec3b& c) { return std::abs(c[0] - c[2]) < 6 && std::abs(c[1] - c[2]) < 6; }

class OverlayTest : public ::testing::Test {
 protected:
  cv::Mat gray_{height, width, CV_8UC1, cv::Scalar(100)};
  GrayView raw_{gray_.data, width, height};
};

TEST_F(OverlayTest, TintsTheFloorFromWhereItComesIntoViewUpToTheRange) {
  Obstacles o = straightAhead(BearingState::Free, 1.2F);
  for (Bearing& b : o.bearings) b.near = 0.6F;
  const cv::Mat overlay = drawOverlay(raw_, o);
  EXPECT_EQ(overlay.cols, width * enlarged);
  EXPECT_GT(overlay.rows, height * enlarged) << "a caption below";
  for (const double side : {-0.03, 0.03}) {
    EXPECT_TRUE(isGray(colorAt(overlay, o, 0.05 + 0.55, side)));
    EXPECT_TRUE(isGreen(colorAt(overlay, o, 0.05 + 0.65, side)));
    EXPECT_TRUE(isGreen(colorAt(overlay, o, 0.05 + 1.15, side)));
    EXPECT_TRUE(isGray(colorAt(overlay, o, 0.05 + 1.27, side)));
    EXPECT_TRUE(isGray(colorAt(overlay, o, 0.05 + 1.6, side)));
  }
  EXPECT_TRUE(isGray(colorAt(overlay, o, 0.9, 0.9 * std::tan(0.25)))) << "unknown bearings";
}

TEST_F(OverlayTest, ABlockedBearingIsAmberBehindTheFloorThatWasSeen) {
  const Obstacles o = straightAhead(BearingState::Blocked, 0.8F);
  const cv::Mat overlay = drawOverlay(raw_, o);
  EXPECT_TRUE(isGreen(colorAt(overlay, o, 0.05 + 0.6, 0.03)));
  EXPECT_TRUE(isAmber(colorAt(overlay, o, 0.05 + 1.2, 0.03)));
  EXPECT_TRUE(isGray(colorAt(overlay, o, 0.05 + 2.3, 0.03)));
}

TEST_F(OverlayTest, AContactIsARedDotWithAWhiteRim) {
  Obstacles o = straightAhead(BearingState::Occupied, 0.9F);
  Contact contact;
  contact.u = 40.0F;
  contact.v = 150.0F;
  o.contacts = {contact};
  const cv::Mat overlay = drawOverlay(raw_, o);
  const int u = 40 * enlarged + 1, v = 150 * enlarged + 1;
  EXPECT_GT(overlay.at<cv::Vec3b>(v, u)[2], 200);
  EXPECT_LT(overlay.at<cv::Vec3b>(v, u)[1], 90);
  EXPECT_GT(overlay.at<cv::Vec3b>(v, u + 6)[1], 200);
  EXPECT_TRUE(isGray(overlay.at<cv::Vec3b>(v, u + 12)));
}

TEST_F(OverlayTest, ShowsTheHorizonWhereItIsInThePicture) {
  const auto blueRow = [&](double pitch) {
    Obstacles o = straightAhead(BearingState::Unknown, 0.0F);
    o.view = viewOf(pitch);
    const cv::Mat overlay = drawOverlay(raw_, o);
    for (int v = 0; v < height * enlarged; ++v)
      for (int u = 900; u < 1100; ++u) {
        const cv::Vec3b c = overlay.at<cv::Vec3b>(v, u);
        if (c[0] > c[2] + 60) return v;
      }
    return -1;
  };
  const double expected = (119.5 - 260.0 * std::tan(0.2) + 0.5) * enlarged;
  EXPECT_NEAR(blueRow(0.2), expected, 3.0);
  EXPECT_EQ(blueRow(0.9), -1);
}

TEST_F(OverlayTest, SurvivesViewsWithoutFloorOrFocus) {
  EXPECT_TRUE(drawOverlay({}, straightAhead(BearingState::Free, 1.0F)).empty());
  Obstacles level = straightAhead(BearingState::Free, 1.0F);
  level.view = viewOf(0.0);
  level.focus.f = {0.0, 1.0, 0.0};
  EXPECT_FALSE(drawOverlay(raw_, level).empty());
  Obstacles nothing;
  nothing.view = viewOf(-0.9);
  EXPECT_FALSE(drawOverlay(raw_, nothing, "a note").empty());
}

TEST(Rectified, AgreesWithAnIndependentUndistortion) {
  cv::Mat noise(height, width, CV_8UC1);
  cv::randu(noise, 0, 255);
  cv::GaussianBlur(noise, noise, {9, 9}, 3.0);
  const CameraModel camera({width, height, 260, 258, 161, 118}, {0.1, -0.15, 0.002, -0.001, 0.02});
  const cv::Matx33d K(260, 0, 161, 0, 258, 118, 0, 0, 1);
  const cv::Mat D = (cv::Mat_<double>(1, 5) << 0.1, -0.15, 0.002, -0.001, 0.02);
  cv::Mat map_u, map_v, expected;
  cv::initUndistortRectifyMap(K, D, cv::Mat(), K, {width, height}, CV_32FC1, map_u, map_v);
  cv::remap(noise, expected, map_u, map_v, cv::INTER_LINEAR);
  const cv::Mat ours = rectified({noise.data, width, height}, camera);
  EXPECT_LE(cv::norm(ours, expected, cv::NORM_INF), 2.0);
  EXPECT_GT(cv::norm(ours, noise, cv::NORM_INF), 5.0);
}

}  // namespace
}  // namespace ipm_mapping

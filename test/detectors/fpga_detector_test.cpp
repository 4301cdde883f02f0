#include "ipm_mapping/detectors/fpga_detector.hpp"

#include <gtest/gtest.h>

#include <utility>

namespace ipm_mapping {
namespace {

FrameStatus statusOfSize(int width, int height) {
  FpgaDetector detector{Parameters{}};
  detector.setCamera(CameraModel({width, height, 500, 500, 0.5 * width, 0.5 * height}, {}),
                     cameraPose(0.05, 0.0, 0.45, 0.42));
  const Image<std::uint8_t> picture(width, height);
  Obstacles obstacles;
  return detector.process({0, 0.0, std::as_const(picture).view(), {}}, obstacles);
}

TEST(FpgaDetector, SaysThatACameraDoesNotFitItsRegisters) {
  EXPECT_EQ(statusOfSize(640, 480), FrameStatus::NoReference);
  EXPECT_EQ(statusOfSize(641, 480), FrameStatus::CameraUnsupported);
  EXPECT_EQ(statusOfSize(640, 481), FrameStatus::CameraUnsupported);
  EXPECT_TRUE(isFault(FrameStatus::CameraUnsupported));
  EXPECT_STREQ(name(FrameStatus::CameraUnsupported), "camera_unsupported");
}

TEST(FpgaDetector, NeedsACamera) {
  FpgaDetector detector{Parameters{}};
  const Image<std::uint8_t> picture(640, 480);
  Obstacles obstacles;
  EXPECT_EQ(detector.process({0, 0.0, picture.view(), {}}, obstacles), FrameStatus::NoCamera);
}

}  // namespace
}  // namespace ipm_mapping

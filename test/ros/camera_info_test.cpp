#include "ipm_mapping/ros/camera_info.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>

namespace ipm_mapping {
namespace {

sensor_msgs::CameraInfo vga() {
  sensor_msgs::CameraInfo info;
  info.width = 640;
  info.height = 480;
  info.distortion_model = "plumb_bob";
  info.K = {500, 0, 320, 0, 510, 240, 0, 0, 1};
  info.D = {-0.1, 0.02, 0.001, -0.002, 0.003};
  return info;
}

std::string refusalOf(const sensor_msgs::CameraInfo& info) {
  CameraModel camera;
  return toCamera(info, camera).value_or("accepted");
}

bool names(const std::string& text, const std::string& what) {
  return text.find(what) != std::string::npos;
}

TEST(CameraInfo, FullFrameIsTakenAsItIs) {
  CameraModel camera;
  ASSERT_EQ(toCamera(vga(), camera), std::nullopt);
  EXPECT_TRUE(camera.intrinsics() == (Intrinsics{640, 480, 500, 510, 320, 240}));
  EXPECT_TRUE(camera.distortion() == (Distortion{-0.1, 0.02, 0.001, -0.002, 0.003}));
}

TEST(CameraInfo, RegionOfInterestMovesThePrincipalPoint) {
  auto info = vga();
  info.roi.x_offset = 100;
  info.roi.y_offset = 40;
  info.roi.width = 320;
  info.roi.height = 400;
  CameraModel camera;
  ASSERT_EQ(toCamera(info, camera), std::nullopt);
  EXPECT_TRUE(camera.intrinsics() == (Intrinsics{320, 400, 500, 510, 220, 200}));
}

TEST(CameraInfo, BinnedPixelCentresAreTheMeansOfTheirSensorPixels) {
  auto info = vga();
  info.binning_x = 2;
  info.binning_y = 4;
  CameraModel camera;
  ASSERT_EQ(toCamera(info, camera), std::nullopt);
  const Intrinsics& k = camera.intrinsics();
  EXPECT_EQ(k.width, 320);
  EXPECT_EQ(k.height, 120);
  // The ray of a binned pixel is the mean ray of the sensor pixels that it is made of.
  const double x_sensor = ((20 - 320.0) / 500 + (21 - 320.0) / 500) / 2;
  EXPECT_NEAR((10 - k.cx) / k.fx, x_sensor, 1e-12);
  const double y_sensor = ((40 + 41 + 42 + 43) / 4.0 - 240) / 510;
  EXPECT_NEAR((10 - k.cy) / k.fy, y_sensor, 1e-12);
}

TEST(CameraInfo, UnusableCalibrationsAreRefusedByTheFieldsName) {
  auto info = vga();
  info.K[0] = 0.0;
  EXPECT_TRUE(names(refusalOf(info), "K[0] = 0")) << refusalOf(info);
  info = vga();
  info.distortion_model = "equidistant";
  EXPECT_TRUE(names(refusalOf(info), "'equidistant'")) << refusalOf(info);
  info = vga();
  info.K[1] = 0.5;
  EXPECT_TRUE(names(refusalOf(info), "K[1]")) << refusalOf(info);
  info = vga();
  info.width = 0;
  EXPECT_TRUE(names(refusalOf(info), "0x480")) << refusalOf(info);
  info = vga();
  info.roi.x_offset = 600;
  info.roi.width = 100;
  EXPECT_TRUE(names(refusalOf(info), "roi")) << refusalOf(info);
  info = vga();
  info.roi.y_offset = 4000000000U;
  EXPECT_TRUE(names(refusalOf(info), "roi")) << refusalOf(info);
  info = vga();
  info.binning_x = 1000;
  EXPECT_TRUE(names(refusalOf(info), "binning")) << refusalOf(info);
}

TEST(CameraInfo, SizeMismatchNamesBothSizes) {
  CameraModel camera;
  ASSERT_EQ(toCamera(vga(), camera), std::nullopt);
  EXPECT_EQ(checkSize(camera, 640, 480), std::nullopt);
  const auto refusal = checkSize(camera, 320, 240);
  ASSERT_TRUE(refusal);
  EXPECT_TRUE(names(*refusal, "320x240") && names(*refusal, "640x480")) << *refusal;
}

class CalibrationFile : public testing::Test {
 protected:
  void write(const std::string& text) { std::ofstream(path_) << text; }
  void TearDown() override { std::remove(path_.c_str()); }
  std::string path_ = testing::TempDir() + "/calibration_file_test.yaml";
  sensor_msgs::CameraInfo info_;
};

TEST_F(CalibrationFile, OfTheCalibratorIsRead) {
  write(
      "image_width: 640\nimage_height: 480\ncamera_name: front\n"
      "camera_matrix:\n  rows: 3\n  cols: 3\n  data: [500, 0, 320, 0, 510, 240, 0, 0, 1]\n"
      "distortion_model: plumb_bob\n"
      "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [-0.1, 0.02, 0.001, -0.002, "
      "0.003]\n");
  ASSERT_EQ(readCalibrationFile(path_, info_), std::nullopt);
  CameraModel camera, expected;
  ASSERT_EQ(toCamera(info_, camera), std::nullopt);
  ASSERT_EQ(toCamera(vga(), expected), std::nullopt);
  EXPECT_TRUE(camera == expected);
}

TEST_F(CalibrationFile, AsRostopicPrintsItIsRead) {
  write(
      "height: 480\nwidth: 640\ndistortion_model: plumb_bob\n"
      "D: [-0.1, 0.02, 0.001, -0.002, 0.003]\nK: [500, 0, 320, 0, 510, 240, 0, 0, 1]\n");
  ASSERT_EQ(readCalibrationFile(path_, info_), std::nullopt);
  EXPECT_EQ(info_.K, vga().K);
  EXPECT_EQ(info_.D, vga().D);
}

TEST_F(CalibrationFile, BrokenOnesAreRefusedByPathAndReason) {
  EXPECT_TRUE(names(*readCalibrationFile("/nowhere/x.yaml", info_), "/nowhere/x.yaml"));
  write("image_width: 640\n");
  EXPECT_TRUE(names(*readCalibrationFile(path_, info_), "image_height"));
  write("width: 640\nheight: 480\nK: [1, 2, 3]\nD: []\n");
  EXPECT_TRUE(names(*readCalibrationFile(path_, info_), "numbers"));
  write("{{{");
  EXPECT_TRUE(names(*readCalibrationFile(path_, info_), path_));
}

}  // namespace
}  // namespace ipm_mapping

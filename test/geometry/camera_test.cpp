#include "ipm_mapping/geometry/camera.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <random>

namespace ipm_mapping {
namespace {

constexpr Intrinsics vga{640, 480, 525.0, 520.0, 318.5, 241.25};
const std::vector<Distortion> lenses{{},
                                     {0.08, -0.16, 0.0, 0.0, 0.02},
                                     {-0.28, 0.07, 0.001, -0.0005, 0.0},
                                     {0.1, -0.25, 0.002, 0.003, 0.1}};

/// OpenCV's idea of where a normalised point lands.
cv::Point2d projected(const Intrinsics& k, const Distortion& d, double x, double y) {
  const cv::Matx33d K(k.fx, 0, k.cx, 0, k.fy, k.cy, 0, 0, 1);
  const std::vector<double> D{d.k1, d.k2, d.p1, d.p2, d.k3};
  std::vector<cv::Point2d> pixels;
  cv::projectPoints(std::vector<cv::Point3d>{{2.0 * x, 2.0 * y, 2.0}}, cv::Vec3d(), cv::Vec3d(), K,
                    D, pixels);
  return pixels[0];
}

TEST(CameraModel, DistortsAsOpenCvProjects) {
  for (const Distortion& lens : lenses) {
    const CameraModel camera(vga, lens);
    for (int v = -20; v < 500; v += 13)
      for (int u = -20; u < 660; u += 17) {
        double raw_u = 0, raw_v = 0;
        ASSERT_TRUE(camera.distortPixel(u, v, raw_u, raw_v));
        const cv::Point2d expected =
            projected(vga, lens, (u - vga.cx) / vga.fx, (v - vga.cy) / vga.fy);
        ASSERT_NEAR(raw_u, expected.x, 1e-9);
        ASSERT_NEAR(raw_v, expected.y, 1e-9);
      }
  }
}

TEST(CameraModel, OpenCvUndistortsBackWhatItDistorted) {
  const CameraModel camera(vga, lenses[1]);
  const cv::Matx33d K(vga.fx, 0, vga.cx, 0, vga.fy, vga.cy, 0, 0, 1);
  const Distortion& d = camera.distortion();
  for (int v = 0; v < 480; v += 40)
    for (int u = 0; u < 640; u += 40) {
      double raw_u = 0, raw_v = 0;
      ASSERT_TRUE(camera.distortPixel(u, v, raw_u, raw_v));
      std::vector<cv::Point2d> back;
      cv::undistortPoints(std::vector<cv::Point2d>{{raw_u, raw_v}}, back, K,
                          std::vector<double>{d.k1, d.k2, d.p1, d.p2, d.k3}, cv::noArray(), K,
                          cv::TermCriteria(cv::TermCriteria::COUNT, 200, 0));
      EXPECT_NEAR(back[0].x, u, 1e-6);
      EXPECT_NEAR(back[0].y, v, 1e-6);
    }
}

TEST(CameraModel, WithoutDistortionAPixelStays) {
  const CameraModel camera(vga, {});
  double u = 0, v = 0;
  ASSERT_TRUE(camera.distortPixel(12.25, 400.5, u, v));
  EXPECT_NEAR(u, 12.25, 1e-12);
  EXPECT_NEAR(v, 400.5, 1e-12);
  EXPECT_TRUE(std::isinf(camera.turningRadiusSquared()));
}

/// r (1 + k1 r^2 + k2 r^4 + k3 r^6): the first local maximum, found by walking outwards.
double turningRadiusByWalking(const Distortion& d, double farthest) {
  const auto mapped = [&d](double r) {
    const double q = r * r;
    return r * (1.0 + q * (d.k1 + q * (d.k2 + q * d.k3)));
  };
  constexpr double step = 1e-5;
  for (double r = step; r < farthest; r += step)
    if (mapped(r + step) <= mapped(r)) return r;
  return std::numeric_limits<double>::infinity();
}

TEST(CameraModel, PixelsBeyondTheTurningRadiusAreRefused) {
  for (const Distortion& lens :
       {Distortion{-0.28, 0.0, 0, 0, 0}, Distortion{0.08, -0.16, 0, 0, 0.0},
        Distortion{-0.4, 0.1, 0, 0, -0.02}, Distortion{0.3, -0.5, 0, 0, 0.1},
        Distortion{0.0, 0.0, 0, 0, -0.001}}) {
    const CameraModel camera(vga, lens);
    const double turning = turningRadiusByWalking(lens, 9.0);
    ASSERT_TRUE(std::isfinite(turning)) << "the case is meant to turn over";
    EXPECT_NEAR(std::sqrt(camera.turningRadiusSquared()), turning, 1e-4);
    double u = 0, v = 0, last = -1.0;
    for (double r = 0.0; r < turning - 1e-3; r += 0.01) {
      ASSERT_TRUE(camera.distortNormalized(r, 0.0, u, v));
      EXPECT_GT(u, last) << "inside, farther out stays farther out";
      last = u;
    }
    for (const double angle : {0.0, 1.0, 2.5, 4.0}) {
      const double r = turning + 1e-3;
      EXPECT_FALSE(camera.distortNormalized(r * std::cos(angle), r * std::sin(angle), u, v));
    }
    EXPECT_FALSE(camera.distortNormalized(1e6, 0.0, u, v));
    EXPECT_FALSE(camera.distortNormalized(std::nan(""), 0.0, u, v));
  }
}

TEST(CameraModel, UsableCalibrationsPassTheCheck) {
  for (const std::vector<double>& D :
       std::vector<std::vector<double>>{{}, {0.1, 0.2, 0.0, 0.0}, {0.1, 0.2, 0.0, 0.0, 0.3}})
    for (const char* model : {"plumb_bob", ""})
      EXPECT_EQ(CameraModel::check(vga, model, D), std::nullopt);
}

TEST(CameraModel, UnusableCalibrationsAreRefusedByName) {
  const auto refusal = [](const Intrinsics& k, const char* model, const std::vector<double>& D) {
    return CameraModel::check(k, model, D).value_or("accepted");
  };
  Intrinsics uncalibrated = vga, sizeless = vga, off = vga;
  uncalibrated.fx = 0.0;
  sizeless.height = 0;
  off.cx = std::nan("");
  EXPECT_NE(refusal(uncalibrated, "plumb_bob", {}).find("K[0] = 0"), std::string::npos);
  EXPECT_NE(refusal(sizeless, "plumb_bob", {}).find("640x0"), std::string::npos);
  EXPECT_NE(refusal(off, "plumb_bob", {}).find("principal point"), std::string::npos);
  EXPECT_NE(refusal(vga, "equidistant", {}).find("'equidistant'"), std::string::npos);
  EXPECT_NE(refusal(vga, "plumb_bob", {0, 0, 0, 0, 0, 0, 0, 0}).find("D has 8"), std::string::npos);
  EXPECT_NE(refusal(vga, "plumb_bob", {0, std::nan("")}).find("not finite"), std::string::npos);
}

TEST(CameraModel, MissingCoefficientsAreZero) {
  EXPECT_TRUE(
      (CameraModel::distortionFrom({0.1, 0.2, 0.3, 0.4}) == Distortion{0.1, 0.2, 0.3, 0.4, 0.0}));
  EXPECT_TRUE(CameraModel::distortionFrom({}).none());
}

TEST(CameraPose, AxesOfALevelCameraLookForward) {
  const CameraPose pose = cameraPose(0.1, -0.2, 0.5, 0.0);
  EXPECT_TRUE((pose * Eigen::Vector3d(0, 0, 1)).isApprox(Eigen::Vector3d(1.1, -0.2, 0.5), 1e-12));
  EXPECT_TRUE((pose * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(0.1, -1.2, 0.5), 1e-12));
  EXPECT_TRUE((pose * Eigen::Vector3d(0, 1, 0)).isApprox(Eigen::Vector3d(0.1, -0.2, -0.5), 1e-12));
}

TEST(CameraPose, PitchLooksDownYawLooksLeftRollKeepsTheAxis) {
  const auto axis = [](double pitch, double yaw, double roll) {
    return Eigen::Vector3d(cameraPose(0, 0, 1, pitch, yaw, roll).linear().col(2));
  };
  EXPECT_TRUE(
      axis(0.3, 0.0, 0.0).isApprox(Eigen::Vector3d(std::cos(0.3), 0.0, -std::sin(0.3)), 1e-12));
  EXPECT_TRUE(
      axis(0.0, 0.4, 0.0).isApprox(Eigen::Vector3d(std::cos(0.4), std::sin(0.4), 0.0), 1e-12));
  EXPECT_TRUE(axis(0.3, 0.4, 1.0).isApprox(axis(0.3, 0.4, 0.0), 1e-12));
  for (const double pitch : {-1.2, -0.1, 0.0, 0.42, 1.4})
    for (const double yaw : {-2.0, 0.0, 1.0})
      for (const double roll : {-0.5, 0.0, 0.5})
        EXPECT_NEAR(pitchOf(cameraPose(1, 2, 3, pitch, yaw, roll)), pitch, 1e-12);
}

TEST(CameraPose, IsARotationWhateverTheAngles) {
  const Eigen::Matrix3d R = cameraPose(0, 0, 1, 0.7, -1.1, 2.2).linear();
  EXPECT_TRUE((R * R.transpose()).isIdentity(1e-12));
  EXPECT_NEAR(R.determinant(), 1.0, 1e-12);
}

}  // namespace
}  // namespace ipm_mapping

#include "ipm_mapping/stages/undistort_warp.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "support/pictures.hpp"
#include "support/views.hpp"

namespace ipm_mapping::test {
namespace {

constexpr double tolerance = 0.02;             // pixels
constexpr double boundary = 1.0 / 256 + 1e-3;  // pixels: rounding, and single precision

struct Setting {
  std::string name;
  GroundView view;
};

std::vector<Setting> settings() {
  std::vector<Setting> all;
  for (const auto& [camera_name, camera] : cameras()) {
    for (const auto& [pose_name, pose] : cameraPoses()) {
      for (const auto& [motion_name, motion] : motions()) {
        GroundView view;
        view.camera = camera;
        view.T_base_camera = pose;
        view.motion = motion;
        all.push_back({camera_name + " / " + pose_name + " / " + motion_name, view});
      }
    }
  }
  return all;
}

/// Rows or columns alternating between 0 and 255: an error of e pixels in the coordinate changes
/// the interpolated grey by 255 e.
Picture stripes(const CameraModel& camera, bool across) {
  Picture picture(camera.width(), camera.height());
  for (int v = 0; v < camera.height(); ++v)
    for (int u = 0; u < camera.width(); ++u) picture(u, v) = ((across ? u : v) & 1) ? 255 : 0;
  return picture;
}
double stripesAt(double coordinate) {
  return 255.0 * (1.0 - std::abs(std::fmod(coordinate, 2.0) - 1.0));
}
/// A slow ramp: 255 over the whole picture, against errors of whole stripes.
Picture ramp(const CameraModel& camera, bool across) {
  Picture picture(camera.width(), camera.height());
  for (int v = 0; v < camera.height(); ++v)
    for (int u = 0; u < camera.width(); ++u)
      picture(u, v) =
          static_cast<std::uint8_t>(across ? u * 255 / camera.width() : v * 255 / camera.height());
  return picture;
}

using Sampler = std::function<void(GrayView raw, GrayBuffer out, GrayBuffer valid)>;
using Oracle = std::function<RawPoint(int u, int v)>;

/// Worst distance of the sampled coordinates to the oracle's, pixels, and the share of pixels seen.
struct Accuracy {
  double worst = 0.0;
  int at_u = 0, at_v = 0;
  int wrong_validity = 0;
  int seen = 0;
};

Accuracy measure(const CameraModel& camera, const Sampler& sample, const Oracle& oracle) {
  const int W = camera.width(), H = camera.height();
  Picture out_u(W, H), out_v(W, H), ramp_u(W, H), ramp_v(W, H), valid(W, H);
  sample(stripes(camera, true).view(), out_u.view(), valid.view());
  sample(stripes(camera, false).view(), out_v.view(), valid.view());
  sample(ramp(camera, true).view(), ramp_u.view(), valid.view());
  sample(ramp(camera, false).view(), ramp_v.view(), valid.view());
  EXPECT_TRUE(out_u.guarded() && out_v.guarded() && valid.guarded());
  Accuracy accuracy;
  for (int v = 0; v < H; ++v) {
    for (int u = 0; u < W; ++u) {
      const RawPoint expected = oracle(u, v);
      const bool seen = valid(u, v) == 255;
      if (seen != expected.valid && std::abs(expected.margin) > boundary) ++accuracy.wrong_validity;
      EXPECT_TRUE(seen || valid(u, v) == 0);
      if (!(seen && expected.valid)) continue;
      ++accuracy.seen;
      const auto error = [](int grey, double exact) {
        return std::max(std::abs(grey - exact) - 0.54, 0.0) / 255.0;
      };
      double distance = std::hypot(error(out_u(u, v), stripesAt(expected.u)),
                                   error(out_v(u, v), stripesAt(expected.v)));
      if (std::abs(ramp_u(u, v) - expected.u * 255 / W) > 1.6 ||
          std::abs(ramp_v(u, v) - expected.v * 255 / H) > 1.6)
        distance = 99.0;
      if (distance > accuracy.worst) {
        accuracy.worst = distance;
        accuracy.at_u = u;
        accuracy.at_v = v;
      }
    }
  }
  return accuracy;
}

TEST(Warp, CoordinatesAndValidityFollowTheExactMap) {
  for (const Setting& s : settings()) {
    UndistortWarp warp(s.view.camera);
    const Accuracy accuracy = measure(
        s.view.camera,
        [&](GrayView raw, GrayBuffer out, GrayBuffer valid) {
          for (int v = 0; v < valid.height; ++v) std::fill_n(valid.row(v), valid.width, 255);
          warp.warp(raw, s.view, out, valid);
        },
        [&](int u, int v) { return referenceSample(s.view, u, v); });
    EXPECT_LT(accuracy.worst, tolerance)
        << s.name << " at (" << accuracy.at_u << ", " << accuracy.at_v << ")";
    EXPECT_EQ(accuracy.wrong_validity, 0) << s.name;
    EXPECT_GT(accuracy.seen, s.view.camera.width() * s.view.camera.height() / 8) << s.name;
  }
}

TEST(Undistort, CoordinatesAndValidityFollowTheExactMap) {
  for (const auto& [name, camera] : cameras()) {
    UndistortWarp warp(camera);
    const CameraModel& lens = camera;
    const Accuracy accuracy = measure(
        camera,
        [&](GrayView raw, GrayBuffer out, GrayBuffer valid) { warp.undistort(raw, out, valid); },
        [&](int u, int v) { return currentSample(lens, u, v); });
    EXPECT_LT(accuracy.worst, 0.007) << name;  // rounding only
    EXPECT_EQ(accuracy.wrong_validity, 0) << name;
    EXPECT_GT(accuracy.seen, camera.width() * camera.height() / 2) << name;
  }
}

TEST(Undistort, AgreesWithOpenCvOnASmoothPicture) {
  std::mt19937 random(13);
  for (const auto& [name, camera] : cameras()) {
    const int W = camera.width(), H = camera.height();
    Picture raw = noise(W, H, random), out(W, H), valid(W, H);
    cv::Mat smooth;
    cv::GaussianBlur(raw.mat(), smooth, {0, 0}, 4.0);
    cv::normalize(smooth, smooth, 0, 255, cv::NORM_MINMAX);
    smooth.copyTo(raw.mat());
    UndistortWarp(camera).undistort(raw.view(), out.view(), valid.view());
    const Distortion& d = camera.distortion();
    cv::Mat expected;
    const Eigen::Matrix3d K = camera.intrinsics().matrix();
    const cv::Matx33d k(K(0, 0), 0, K(0, 2), 0, K(1, 1), K(1, 2), 0, 0, 1);
    cv::undistort(raw.mat(), expected, k, cv::Vec<double, 5>(d.k1, d.k2, d.p1, d.p2, d.k3));
    cv::Mat off;
    cv::absdiff(out.mat(), expected, off);
    double worst = 0;
    cv::minMaxLoc(off, nullptr, &worst, nullptr, nullptr, valid.mat());
    EXPECT_LE(worst, 3.0) << name;  // OpenCV rounds coordinates to 1/32 px
    EXPECT_GT(cv::countNonZero(valid.mat()), W * H / 2) << name;
  }
}

TEST(Undistort, WithoutDistortionIsTheIdentity) {
  std::mt19937 random(14);
  const CameraModel camera({97, 61, 80, 80, 48, 30}, {});
  const Picture raw = noise(97, 61, random);
  Picture out(97, 61), valid(97, 61);
  UndistortWarp(camera).undistort(raw.view(), out.view(), valid.view());
  EXPECT_TRUE(equal(out, raw));
  EXPECT_TRUE(equal(valid, Picture(97, 61, 255)));
}

TEST(Warp, WithoutMotionAndDistortionIsTheIdentityBelowTheHorizon) {
  std::mt19937 random(15);
  GroundView view;
  view.camera = CameraModel({160, 120, 140, 140, 79.5, 59.5}, {});
  view.T_base_camera = cameraPose(0.0, 0.0, 0.4, 0.0);  // horizon between rows 59 and 60
  const Picture raw = noise(160, 120, random);
  Picture out(160, 120), valid(160, 120, 255);
  UndistortWarp(view.camera).warp(raw.view(), view, out.view(), valid.view());
  for (int v = 0; v < 120; ++v) {
    for (int u = 0; u < 160; ++u) {
      ASSERT_EQ(valid(u, v), v >= 60 ? 255 : 0) << u << " " << v;
      ASSERT_EQ(out(u, v), v >= 60 ? raw(u, v) : 0) << u << " " << v;
    }
  }
}

TEST(Warp, KeepsPixelsInvalidThatWereSoBefore) {
  std::mt19937 random(16);
  GroundView view;
  view.camera = CameraModel({160, 120, 140, 140, 79.5, 59.5}, {});
  view.T_base_camera = cameraPose(0.0, 0.0, 0.4, 0.5);
  view.motion = {0.05, 0.0, 0.0};
  const Picture raw = noise(160, 120, random);
  const Picture before = speckle(160, 120, random, 0.5);
  Picture out(160, 120), valid(160, 120, 255), anded = before;
  UndistortWarp warp(view.camera);
  warp.warp(raw.view(), view, out.view(), valid.view());
  warp.warp(raw.view(), view, out.view(), anded.view());
  for (int v = 0; v < 120; ++v)
    for (int u = 0; u < 160; ++u) ASSERT_EQ(anded(u, v), valid(u, v) & before(u, v));
}

TEST(Warp, ServesPicturesOfEverySize) {
  // Tails of wide loops and the last rows between two exact ones; a picture of one row or one
  // column has no pixel to interpolate with and stays invalid.
  std::mt19937 random(17);
  for (const cv::Size size : awkwardSizes()) {
    GroundView view;
    view.camera = CameraModel(
        {size.width, size.height, 20, 20, (size.width - 1) / 2.0, (size.height - 1) / 2.0},
        {-0.1, 0, 0, 0, 0});
    view.T_base_camera = cameraPose(0.0, 0.0, 0.4, 1.2);
    view.motion = {0.01, 0.0, 0.0};
    const Picture raw = noise(size.width, size.height, random);
    Picture current(size.width, size.height), warped(size.width, size.height);
    Picture valid(size.width, size.height);
    UndistortWarp warp(view.camera);
    warp.undistort(raw.view(), current.view(), valid.view());
    warp.warp(raw.view(), view, warped.view(), valid.view());
    EXPECT_TRUE(current.guarded() && warped.guarded() && valid.guarded()) << size;
    int wrong = 0;
    for (int v = 0; v < size.height; ++v) {
      for (int u = 0; u < size.width; ++u) {
        const RawPoint now = currentSample(view.camera, u, v), then = referenceSample(view, u, v);
        const double margin = std::min(std::abs(now.margin), std::abs(then.margin));
        const bool expected = now.valid && then.valid && size.width > 1 && size.height > 1;
        if (margin > boundary) wrong += (valid(u, v) == 255) != expected;
      }
    }
    EXPECT_EQ(wrong, 0) << size;
  }
}

}  // namespace
}  // namespace ipm_mapping::test

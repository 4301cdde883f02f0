#pragma once
// A tiny world for end-to-end tests: a textured floor, upright boxes, one camera. Every raw pixel
// is one ray (or a few), so that the truth is exact.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "ipm_mapping/detector.hpp"
#include "ipm_mapping/geometry/ground_view.hpp"
#include "ipm_mapping/image_view.hpp"

namespace ipm_mapping::test {

/// An upright box on the floor of odom, metres.
struct Box {
  double x0, x1, y0, y1, height;
};

/// Grey between 0 and 1 from a lattice of random values, `cell` metres apart, blended smoothly.
class Texture {
 public:
  explicit Texture(std::uint32_t seed, double cell) : seed_(seed), cell_(cell) {}
  [[nodiscard]] double operator()(double s, double t) const {
    const double a = s / cell_, b = t / cell_;
    const double i = std::floor(a), j = std::floor(b);
    const double fa = smooth(a - i), fb = smooth(b - j);
    return (corner(i, j) * (1 - fa) + corner(i + 1, j) * fa) * (1 - fb) +
           (corner(i, j + 1) * (1 - fa) + corner(i + 1, j + 1) * fa) * fb;
  }

 private:
  static double smooth(double t) { return t * t * (3 - 2 * t); }
  [[nodiscard]] double corner(double i, double j) const {
    auto h = static_cast<std::uint32_t>(static_cast<std::int64_t>(i) * 73856093 ^
                                        static_cast<std::int64_t>(j) * 19349663) ^
             seed_;
    h = (h ^ (h >> 16)) * 0x45d9f3bU;
    h = (h ^ (h >> 16)) * 0x45d9f3bU;
    return static_cast<double>((h ^ (h >> 16)) & 0xFFFF) / 65535.0;
  }
  std::uint32_t seed_;
  double cell_;
};

class RayScene {
 public:
  CameraModel camera;
  CameraPose T_base_camera;
  std::vector<Box> boxes;

  RayScene(const CameraModel& camera_model, const CameraPose& camera_pose)
      : camera(camera_model), T_base_camera(camera_pose) {
    for (int v = 0; v < camera.height(); ++v)
      for (int u = 0; u < camera.width(); ++u)
        for (int i = 0; i < samples; ++i)
          for (int j = 0; j < samples; ++j)
            rays_.push_back(
                undistorted(u + (i + 0.5) / samples - 0.5, v + (j + 0.5) / samples - 0.5));
  }

  [[nodiscard]] Image<std::uint8_t> render(const SE2& T_odom_base) const {
    Image<std::uint8_t> picture(camera.width(), camera.height());
    CameraPose T_odom_camera = CameraPose::Identity();
    T_odom_camera.linear() =
        Eigen::AngleAxisd(T_odom_base.theta, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    T_odom_camera.translation() = Eigen::Vector3d(T_odom_base.x, T_odom_base.y, 0);
    T_odom_camera = T_odom_camera * T_base_camera;
    auto ray = rays_.begin();
    for (int v = 0; v < camera.height(); ++v) {
      for (int u = 0; u < camera.width(); ++u) {
        double sum = 0.0;
        for (int k = 0; k < samples * samples; ++k)
          sum += grey(T_odom_camera.translation(), T_odom_camera.linear() * *ray++);
        picture.at(u, v) = static_cast<std::uint8_t>(std::lround(sum / (samples * samples)));
      }
    }
    return picture;
  }

  /// Distance of a floor point in odom to the outline of the nearest box.
  [[nodiscard]] double distanceToOutline(const Eigen::Vector2d& p) const {
    double nearest = 1e9;
    for (const Box& b : boxes) {
      const double dx = std::max({b.x0 - p.x(), p.x() - b.x1}), outside_x = std::max(dx, 0.0);
      const double dy = std::max({b.y0 - p.y(), p.y() - b.y1}), outside_y = std::max(dy, 0.0);
      const double inside = std::max(dx, dy);
      nearest = std::min(nearest, inside < 0 ? -inside : std::hypot(outside_x, outside_y));
    }
    return nearest;
  }

 private:
  static constexpr int samples = 2;  // a side

  /// Ray of a raw pixel: the lens inverted by fixed-point iteration.
  [[nodiscard]] Eigen::Vector3d undistorted(double u_raw, double v_raw) const {
    const Intrinsics& k = camera.intrinsics();
    const double x_raw = (u_raw - k.cx) / k.fx, y_raw = (v_raw - k.cy) / k.fy;
    double x = x_raw, y = y_raw;
    for (int i = 0; !camera.distortion().none() && i < 30; ++i) {
      double u = 0, v = 0;
      if (!camera.distortNormalized(x, y, u, v)) break;
      x += x_raw - (u - k.cx) / k.fx;
      y += y_raw - (v - k.cy) / k.fy;
    }
    return {x, y, 1.0};
  }
  [[nodiscard]] double grey(const Eigen::Vector3d& eye, const Eigen::Vector3d& ray) const {
    double nearest = 1e9, value = 200.0;  // sky
    if (ray.z() < 0.0) {
      nearest = -eye.z() / ray.z();
      const Eigen::Vector3d p = eye + nearest * ray;
      value = 60.0 + 40.0 * floor_(p.x(), p.y());
    }
    for (const Box& box : boxes) hitBox(box, eye, ray, nearest, value);
    return value;
  }
  void hitBox(const Box& box, const Eigen::Vector3d& eye, const Eigen::Vector3d& ray,
              double& nearest, double& value) const {
    const Eigen::Vector3d low(box.x0, box.y0, 0.0), high(box.x1, box.y1, box.height);
    double enter = -1e9, leave = 1e9;
    int side = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double a = (low[axis] - eye[axis]) / ray[axis],
                   b = (high[axis] - eye[axis]) / ray[axis];
      if (std::min(a, b) > enter) side = axis;
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    if (enter > leave || enter <= 0.0 || enter >= nearest) return;
    nearest = enter;
    value = side == 0 ? 235.0 : 215.0;
  }

  Texture floor_{1, 0.03};
  std::vector<Eigen::Vector3d> rays_;  ///< optical, pixel by pixel
};

/// A wide camera 0.45 m above the floor, pitched down, with a mild lens.
inline RayScene wideScene() {
  return {CameraModel({480, 360, 250, 250, 239.5, 179.5}, {-0.12, 0.03, 0.0005, -0.0005, 0}),
          cameraPose(0.05, 0.0, 0.45, 0.42)};
}

}  // namespace ipm_mapping::test

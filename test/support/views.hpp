#pragma once
// Cameras, poses and motions for the tests, and the plain geometry of a pixel seen from two places:
// a ray, its point on the floor, the other camera. No homography in sight.

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "ipm_mapping/geometry/ground_view.hpp"

namespace ipm_mapping::test {

template <class T>
using Named = std::pair<std::string, T>;

inline std::vector<Named<CameraModel>> cameras() {
  return {
      {"no distortion", {{640, 480, 525, 525, 319.5, 239.5}, {}}},
      {"polynomial turns over, k2 < 0", {{640, 480, 300, 302, 322, 236}, {0.10, -0.25, 0, 0, 0}}},
      {"barrel, tangential",
       {{640, 480, 410, 405, 310, 250}, {-0.32, 0.11, 0.0015, -0.0011, -0.015}}},
      {"depth camera, all five",
       {{320, 240, 262, 263, 160, 118}, {0.2624, -0.9531, -0.0054, 0.0026, 1.1633}}},
  };
}

inline std::vector<Named<CameraPose>> cameraPoses() {
  return {
      {"pitched", cameraPose(0.05, 0.0, 0.45, 0.42)},
      {"level", cameraPose(0.10, 0.0, 0.30, 0.0)},
      {"yaw and roll", cameraPose(0.05, 0.04, 0.50, 0.35, 0.25, 0.12)},
  };
}

inline std::vector<Named<SE2>> motions() {
  return {
      {"forward", {0.10, 0.0, 0.0}},
      {"reverse", {-0.15, 0.0, 0.0}},
      {"turning", {0.12, 0.01, 0.18}},
      {"far", {0.30, -0.05, -0.10}},
  };
}

/// Where the floor point seen at an undistorted current pixel lies in the raw reference picture.
struct RawPoint {
  bool valid = false;
  double u = 0.0, v = 0.0;
  double margin = 0.0;  ///< distance to the nearest condition of validity, roughly in pixels
};

/// Distances to the four borders of the picture; negative outside.
inline double insideBy(const CameraModel& camera, double u, double v) {
  return std::min(std::min(u, v), std::min(camera.width() - 1.0 - u, camera.height() - 1.0 - v));
}

/// Lens of a normalised point, from the definition of plumb_bob.
inline RawPoint throughLens(const CameraModel& camera, double x, double y) {
  const Distortion& d = camera.distortion();
  const Intrinsics& k = camera.intrinsics();
  const double r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2;
  const double radial = 1 + d.k1 * r2 + d.k2 * r4 + d.k3 * r6;
  const double xd = x * radial + 2 * d.p1 * x * y + d.p2 * (r2 + 2 * x * x);
  const double yd = y * radial + d.p1 * (r2 + 2 * y * y) + 2 * d.p2 * x * y;
  RawPoint p;
  p.u = k.fx * xd + k.cx;
  p.v = k.fy * yd + k.cy;
  const double turning = std::isfinite(camera.turningRadiusSquared())
                             ? (std::sqrt(camera.turningRadiusSquared()) - std::sqrt(r2)) * k.fx
                             : 1e9;
  p.margin = std::min(insideBy(camera, p.u, p.v), turning);
  p.valid = p.margin >= 0.0;
  return p;
}

/// Raw sample of the current picture at an undistorted pixel.
inline RawPoint currentSample(const CameraModel& camera, double u, double v) {
  const Intrinsics& k = camera.intrinsics();
  return throughLens(camera, (u - k.cx) / k.fx, (v - k.cy) / k.fy);
}

inline RawPoint referenceSample(const GroundView& view, double u, double v) {
  const Intrinsics& k = view.camera.intrinsics();
  const Eigen::Vector3d ray =
      view.T_base_camera.linear() * Eigen::Vector3d((u - k.cx) / k.fx, (v - k.cy) / k.fy, 1.0);
  RawPoint none;
  none.margin = -std::abs(ray.z()) * k.fy;  // distance to the horizon
  if (!(ray.z() < 0.0)) return none;
  const Eigen::Vector3d eye = view.T_base_camera.translation();
  const Eigen::Vector3d floor = eye - ray * (eye.z() / ray.z());
  const Eigen::Vector2d there = view.motion * Eigen::Vector2d(floor.head<2>());
  const Eigen::Vector3d p =
      view.T_base_camera.inverse() * Eigen::Vector3d(there.x(), there.y(), 0.0);
  if (!(p.z() > 0.0)) return none;
  RawPoint sample = throughLens(view.camera, p.x() / p.z(), p.y() / p.z());
  sample.margin = std::copysign(std::min(std::abs(sample.margin), -none.margin), sample.margin);
  return sample;
}

}  // namespace ipm_mapping::test

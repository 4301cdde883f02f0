#include "ipm_mapping/sweep/polar_grid.hpp"

#include <algorithm>

#include "ipm_mapping/geometry/ground_view.hpp"

namespace ipm_mapping::sweep {
namespace {

constexpr double widest_azimuth = 1.4;  // beyond it a forward-looking pinhole sees nothing usable
constexpr double steepest_r = 4.0;      // 14 degrees from straight down: azimuth loses its meaning
constexpr double min_depth = 0.1;       // z of a unit ray's horizontal part: 84 degrees off axis

bool normalized(const CameraPose& T_base_camera, double azimuth, double r, double& x, double& y) {
  const Eigen::Vector3d ray_base(std::cos(azimuth), std::sin(azimuth), -r);
  const Eigen::Vector3d ray = T_base_camera.linear().transpose() * ray_base;
  if (ray.z() < min_depth) return false;
  x = ray.x() / ray.z();
  y = ray.y() / ray.z();
  return true;
}

/// What the image covers, in azimuth and r.
struct Extent {
  double left = -widest_azimuth;
  double right = widest_azimuth;
  double steepest = 0.0;
};

/// Asks the lens itself, direction by direction: raw corners may see farther than undistorted ones.
Extent extentOf(const CameraModel& camera, const CameraPose& T_base_camera, double least_r) {
  constexpr double step = 0.005;
  Extent extent;
  for (double azimuth = -widest_azimuth; azimuth <= widest_azimuth; azimuth += step) {
    for (double r = least_r; r <= steepest_r; r *= 1.0 + 2.0 * step) {
      double u = 0.0, v = 0.0;
      if (!rawPixel(camera, T_base_camera, azimuth, r, u, v)) continue;
      if (u < 0.0 || v < 0.0 || u > camera.width() - 1 || v > camera.height() - 1) continue;
      extent.left = std::max(extent.left, azimuth);
      extent.right = std::min(extent.right, azimuth);
      extent.steepest = std::max(extent.steepest, r);
    }
  }
  return extent;
}

}  // namespace

PolarGrid makePolarGrid(const CameraModel& camera, const CameraPose& T_base_camera,
                        const GridParameters& parameters, double max_range) {
  PolarGrid grid;
  grid.height = T_base_camera.translation().z();
  grid.lines_per_radian = parameters.lines_per_radian;
  grid.rows_per_log = parameters.rows_per_log;
  const double farthest_contact = grid.height / (max_range * parameters.beyond);
  const Extent extent = extentOf(camera, T_base_camera, farthest_contact);
  grid.left_azimuth = extent.left;
  grid.log_r_far = std::log(farthest_contact * (1.0 - parameters.max_support));
  const double rows = (std::log(extent.steepest) - grid.log_r_far) * grid.rows_per_log;
  if (!(extent.steepest > farthest_contact) || extent.left <= extent.right) return grid;
  grid.lines = static_cast<int>((extent.left - extent.right) * grid.lines_per_radian);
  grid.rows =
      static_cast<int>(rows) / PolarGrid::rows_per_sweep_row * PolarGrid::rows_per_sweep_row;
  return grid;
}

double effectiveMaxRange(const CameraModel& camera, const CameraPose& T_base_camera,
                         double max_range) {
  if (max_range > 0.0) return max_range;
  const double nearest = nearestVisibleFloor(camera, T_base_camera);
  return std::isfinite(nearest) ? std::max(2.0, 3.0 * nearest) : 2.0;
}

bool undistortedPixel(const CameraModel& camera, const CameraPose& T_base_camera, double azimuth,
                      double r, double& u, double& v) {
  double x = 0.0, y = 0.0;
  if (!normalized(T_base_camera, azimuth, r, x, y)) return false;
  u = camera.intrinsics().fx * x + camera.intrinsics().cx;
  v = camera.intrinsics().fy * y + camera.intrinsics().cy;
  return true;
}

bool rawPixel(const CameraModel& camera, const CameraPose& T_base_camera, double azimuth, double r,
              double& u, double& v) {
  double x = 0.0, y = 0.0;
  return normalized(T_base_camera, azimuth, r, x, y) && camera.distortNormalized(x, y, u, v);
}

}  // namespace ipm_mapping::sweep

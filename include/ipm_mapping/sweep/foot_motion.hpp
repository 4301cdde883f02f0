#pragma once

#include <Eigen/Core>
#include <cmath>

#include "ipm_mapping/geometry/se2.hpp"
#include "ipm_mapping/kernels/floor_ray.hpp"
#include "ipm_mapping/sweep/polar_grid.hpp"

namespace ipm_mapping::sweep {

/// A motion of the base, seen from the camera's foot: takes floor points around the current foot to
/// points around the reference foot, axes of the two bases. p_ref = R(theta) p + t with
/// t = R(theta) f + m - f, f the camera's foot in base.
struct FootMotion {
  double c = 1.0, s = 0.0;
  double tx = 0.0, ty = 0.0;

  FootMotion() = default;
  FootMotion(const SE2& motion, const Eigen::Vector2d& foot)
      : c(std::cos(motion.theta)), s(std::sin(motion.theta)) {
    const Eigen::Vector2d t = motion * foot - foot;
    tx = t.x();
    ty = t.y();
  }
  [[nodiscard]] Eigen::Vector2d operator*(const Eigen::Vector2d& p) const {
    return {c * p.x() - s * p.y() + tx, s * p.x() + c * p.y() + ty};
  }
};

/// The floor points of one azimuth around the current foot, seen from the reference; its lines are
/// counted from `lines_before` lines to the left.
inline kernels::FloorRay floorRay(const PolarGrid& grid, const FootMotion& motion, double azimuth,
                                  double lines_before = 0.0) {
  const double c = std::cos(azimuth), s = std::sin(azimuth);
  kernels::FloorRay ray;
  ray.ux = static_cast<float>(motion.c * c - motion.s * s);
  ray.uy = static_cast<float>(motion.s * c + motion.c * s);
  ray.tx = static_cast<float>(motion.tx);
  ray.ty = static_cast<float>(motion.ty);
  ray.rows_per_log = static_cast<float>(grid.rows_per_log);
  ray.lines_per_radian = static_cast<float>(grid.lines_per_radian);
  ray.line_ahead = static_cast<float>(grid.line(0.0) - lines_before);
  return ray;
}

}  // namespace ipm_mapping::sweep

#pragma once

#include <Eigen/Core>
#include <cmath>

#include "ipm_mapping/geometry/se2.hpp"

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

}  // namespace ipm_mapping::sweep

#pragma once

#include "ipm_mapping/geometry/se2.hpp"

namespace ipm_mapping::sweep {

/// What odometry says about one frame. Its stamp may be moved by what the camera's clock is off;
/// two frames are compared as if both had been moved by the same.
struct OdometryOfFrame {
  SE2 T_odom_base;
  Velocity velocity;         ///< of the robot at the stamp
  double time_offset = 0.0;  ///< seconds that the camera's stamp, pose and velocity were moved by

  /// The pose if they had been moved by so much.
  [[nodiscard]] SE2 poseMovedBy(double offset) const {
    return later(T_odom_base, velocity, offset - time_offset);
  }
};

/// Pose of the current frame's base in the reference's, both moved by what the current one is.
[[nodiscard]] inline SE2 odometryBetween(const OdometryOfFrame& reference,
                                         const OdometryOfFrame& current) {
  return reference.poseMovedBy(current.time_offset).inverse() * current.T_odom_base;
}

}  // namespace ipm_mapping::sweep

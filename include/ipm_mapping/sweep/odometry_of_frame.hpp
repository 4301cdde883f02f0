#pragma once

#include <cmath>

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

/// Whether odometry changed from one frame to the next.
[[nodiscard]] inline bool hasChanged(const SE2& step) {
  constexpr double no_motion = 1e-6;  // metres and radians
  return step.distance() + std::abs(step.theta) > no_motion;
}

/// Counts the seconds in which odometry changed: those in which it may have gone wrong. A gyroscope
/// that drifts while the robot stands changes it too.
class GoingClock {
 public:
  void reset() { started_ = false; }
  /// Takes every frame with its stamp; returns the seconds so far.
  double add(const OdometryOfFrame& frame, double stamp) {
    const double clock = stamp - frame.time_offset;
    if (started_) {
      if (hasChanged(last_.inverse() * frame.T_odom_base)) seconds_ += clock - last_clock_;
    }
    started_ = true;
    last_ = frame.T_odom_base;
    last_clock_ = clock;
    return seconds_;
  }

 private:
  bool started_ = false;
  SE2 last_;
  double last_clock_ = 0.0, seconds_ = 0.0;
};

/// Pose of the current frame's base in the reference's, both moved by what the current one is.
[[nodiscard]] inline SE2 odometryBetween(const OdometryOfFrame& reference,
                                         const OdometryOfFrame& current) {
  return reference.poseMovedBy(current.time_offset).inverse() * current.T_odom_base;
}

}  // namespace ipm_mapping::sweep

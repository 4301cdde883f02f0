#pragma once

#include <Eigen/Core>

#include "ipm_mapping/geometry/camera.hpp"
#include "ipm_mapping/geometry/se2.hpp"

namespace ipm_mapping::sweep {

/// What is wrong with the stated pose and with odometry, as one vector. Angles in radians, about
/// the camera's left, its forward and the vertical direction; true height = stated *
/// exp(LogHeight); true way = odometry's * exp(LogScale); true turn = odometry's * (1 + TurnScale)
/// + YawRate * dt; the camera's rows are read in stated + ReadoutTime seconds; an image was taken
/// TimeOffset seconds after its stamp.
struct CalibrationIndex {
  enum : int {
    Pitch,
    Roll,
    Yaw,
    LogHeight,
    LogScale,
    TurnScale,
    YawRate,
    ReadoutTime,
    TimeOffset,
    count
  };
};
using CalibrationVector = Eigen::Matrix<double, CalibrationIndex::count, 1>;
using CalibrationMatrix = Eigen::Matrix<double, CalibrationIndex::count, CalibrationIndex::count>;

/// The stated camera, as the floor's geometry needs it.
struct StatedCamera {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< left, forward, up in base, as columns
  Eigen::Vector2d foot = Eigen::Vector2d::Zero();      ///< in base, metres
  double height = 1.0;                                 ///< metres

  StatedCamera() = default;
  explicit StatedCamera(const CameraPose& T_base_camera);

  /// Takes directions as the stated pose has them to what they are, in base axes.
  [[nodiscard]] Eigen::Matrix3d tilt(const CalibrationVector& state) const;
  /// Column k: how tilt(state) turns with angle k, as a rotation vector in base axes.
  [[nodiscard]] Eigen::Matrix3d turning(const CalibrationVector& state) const;
};

/// The stated pose with what is wrong with it taken away.
[[nodiscard]] CameraPose corrected(const CameraPose& T_base_camera, const CalibrationVector& state);

/// Odometry's motion over `seconds` with what is wrong with it taken away:
/// x, y scaled and turned by half of what the heading was off.
[[nodiscard]] SE2 corrected(const SE2& motion, double seconds, const CalibrationVector& state);
/// How that moves with LogScale, TurnScale and YawRate: columns of d (x, y, theta).
[[nodiscard]] Eigen::Matrix3d correctionSlopes(const SE2& motion, double seconds,
                                               const CalibrationVector& state);

}  // namespace ipm_mapping::sweep

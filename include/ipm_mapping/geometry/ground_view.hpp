#pragma once

#include <Eigen/Core>
#include <optional>

#include "ipm_mapping/geometry/camera.hpp"
#include "ipm_mapping/geometry/ground_homography.hpp"
#include "ipm_mapping/geometry/se2.hpp"

namespace ipm_mapping {

/// Everything a later stage needs to know about how one difference image was made: it travels with
/// the image, so that no stage asks tf or odometry a second time.
struct GroundView {
  double stamp = 0.0;            ///< of the current image, seconds
  double reference_stamp = 0.0;  ///< of the reference image, seconds
  CameraModel camera;
  CameraPose T_base_camera = CameraPose::Identity();
  SE2 T_odom_base;  ///< robot pose at the current image's stamp
  SE2 motion;       ///< M: pose of the current base in the reference base

  /// Floor of the current base to current pixels, and back.
  [[nodiscard]] GroundProjection currentFloor() const;
  /// H_r: floor of the reference base to reference pixels.
  [[nodiscard]] Eigen::Matrix3d H_r() const;
  /// H_c: floor of the *reference* base to current pixels, H_r * M^-1 (eq. 3.20, with M inverted).
  [[nodiscard]] Eigen::Matrix3d H_c() const;
  /// G = H_r H_c^-1 takes an undistorted current pixel to the reference view: the direction of
  /// sampling. Its inverse is the source's T_ipm (eq. 3.23).
  [[nodiscard]] Eigen::Matrix3d G() const;

  /// Floor point under the camera, in base (metres).
  [[nodiscard]] Eigen::Vector2d cameraFoot() const { return T_base_camera.translation().head<2>(); }
  /// Height of the camera over the floor (metres).
  [[nodiscard]] double cameraHeight() const { return T_base_camera.translation().z(); }
};

/// A camera that cannot see the floor is refused: names what is wrong with the pose, or nothing.
[[nodiscard]] std::optional<CalibrationError> checkCameraPose(const CameraPose& T_base_camera);

/// Distance from the camera's foot at which the floor enters the undistorted view on the centre
/// column, metres; infinity where the bottom row is above the horizon.
[[nodiscard]] double nearestVisibleFloor(const CameraModel& camera,
                                         const CameraPose& T_base_camera);

}  // namespace ipm_mapping

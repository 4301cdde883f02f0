#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <optional>

#include "ipm_mapping/geometry/camera.hpp"
#include "ipm_mapping/geometry/se2.hpp"

namespace ipm_mapping {

/// H = K [r1 r2 t] of T_camera_base: floor points (X, Y, 1) of base, metres, to undistorted pixels
/// up to a scale that is the depth in metres (the source, eq. 3.17 and 5.17).
[[nodiscard]] Eigen::Matrix3d groundHomography(const Intrinsics& intrinsics,
                                               const CameraPose& T_base_camera);

/// The floor seen from one place: homography both ways, with the sign of the depth kept.
class GroundProjection {
 public:
  GroundProjection() = default;
  explicit GroundProjection(const Eigen::Matrix3d& H) : H_(H), H_inverse_(H.inverse()) {}

  [[nodiscard]] const Eigen::Matrix3d& H() const { return H_; }
  [[nodiscard]] const Eigen::Matrix3d& inverse() const { return H_inverse_; }

  /// Pixel of a floor point; nothing when the point is not in front of the camera.
  [[nodiscard]] std::optional<Eigen::Vector2d> pixel(const Eigen::Vector2d& floor) const;
  /// Floor point of a pixel (eq. 5.18); nothing on or above the horizon.
  [[nodiscard]] std::optional<Eigen::Vector2d> floor(const Eigen::Vector2d& pixel) const;
  /// Inverse depth of the floor at a pixel, 1/m: positive below the horizon, 0 on it.
  [[nodiscard]] double inverseDepth(double u, double v) const {
    return H_inverse_(2, 0) * u + H_inverse_(2, 1) * v + H_inverse_(2, 2);
  }

 private:
  Eigen::Matrix3d H_ = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d H_inverse_ = Eigen::Matrix3d::Identity();
};

}  // namespace ipm_mapping

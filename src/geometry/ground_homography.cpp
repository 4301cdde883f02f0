#include "ipm_mapping/geometry/ground_homography.hpp"

namespace ipm_mapping {

Eigen::Matrix3d groundHomography(const Intrinsics& intrinsics, const CameraPose& T_base_camera) {
  const CameraPose T_camera_base = T_base_camera.inverse();
  Eigen::Matrix3d r1_r2_t;
  r1_r2_t.col(0) = T_camera_base.linear().col(0);
  r1_r2_t.col(1) = T_camera_base.linear().col(1);
  r1_r2_t.col(2) = T_camera_base.translation();
  return intrinsics.matrix() * r1_r2_t;
}

std::optional<Eigen::Vector2d> GroundProjection::pixel(const Eigen::Vector2d& floor) const {
  const Eigen::Vector3d p = H_ * floor.homogeneous();
  if (!(p.z() > 0.0)) return std::nullopt;
  return p.hnormalized();
}

std::optional<Eigen::Vector2d> GroundProjection::floor(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector3d p = H_inverse_ * pixel.homogeneous();
  if (!(p.z() > 0.0)) return std::nullopt;
  return p.hnormalized();
}

}  // namespace ipm_mapping

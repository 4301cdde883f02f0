#include "ipm_mapping/geometry/ground_view.hpp"

#include <cmath>
#include <limits>
#include <sstream>

namespace ipm_mapping {

GroundProjection GroundView::currentFloor() const {
  return GroundProjection(groundHomography(camera.intrinsics(), T_base_camera));
}

Eigen::Matrix3d GroundView::H_r() const {
  return groundHomography(camera.intrinsics(), T_base_camera);
}

Eigen::Matrix3d GroundView::H_c() const { return H_r() * motion.inverse().matrix(); }

Eigen::Matrix3d GroundView::G() const {
  const Eigen::Matrix3d H = H_r();
  return H * motion.matrix() * H.inverse();
}

std::optional<CalibrationError> checkCameraPose(const CameraPose& T_base_camera) {
  const double height = T_base_camera.translation().z();
  std::ostringstream out;
  if (!T_base_camera.matrix().allFinite()) return std::string("camera pose is not finite");
  if (!(height > 0.0)) {
    out << "camera height " << height << " m: the camera has to be above the floor";
    return out.str();
  }
  if (std::abs(pitchOf(T_base_camera)) > 1.5) {
    out << "camera pitch " << pitchOf(T_base_camera) << " rad: the camera has to look forward";
    return out.str();
  }
  return std::nullopt;
}

double nearestVisibleFloor(const CameraModel& camera, const CameraPose& T_base_camera) {
  const GroundProjection floor(groundHomography(camera.intrinsics(), T_base_camera));
  const auto point = floor.floor({camera.intrinsics().cx, camera.height() - 1.0});
  if (!point) return std::numeric_limits<double>::infinity();
  return (*point - T_base_camera.translation().head<2>()).norm();
}

}  // namespace ipm_mapping

#include "ipm_mapping/sweep/calibration_state.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace ipm_mapping::sweep {
namespace {

using I = CalibrationIndex;

Eigen::Matrix3d crossMatrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

double headingError(const SE2& motion, double seconds, const CalibrationVector& state) {
  return state[I::TurnScale] * motion.theta + state[I::YawRate] * seconds;
}

}  // namespace

StatedCamera::StatedCamera(const CameraPose& T_base_camera)
    : foot(T_base_camera.translation().head<2>()), height(T_base_camera.translation().z()) {
  const Eigen::Vector3d axis = T_base_camera.linear().col(2);
  const double heading = std::atan2(axis.y(), axis.x());
  const double c = std::cos(heading), s = std::sin(heading);
  axes << -s, c, 0, c, s, 0, 0, 0, 1;
}

Eigen::Matrix3d StatedCamera::tilt(const CalibrationVector& state) const {
  const Eigen::Vector3d w = axes * state.head<3>();
  const double angle = w.norm();
  if (angle < 1e-12) return Eigen::Matrix3d::Identity() + crossMatrix(w);
  return Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
}

/// The left Jacobian of SO(3) to second order: angles of a few degrees.
Eigen::Matrix3d StatedCamera::turning(const CalibrationVector& state) const {
  const Eigen::Matrix3d w = crossMatrix(axes * state.head<3>());
  return (Eigen::Matrix3d::Identity() + 0.5 * w + w * w / 6.0) * axes;
}

CameraPose corrected(const CameraPose& T_base_camera, const CalibrationVector& state) {
  CameraPose pose = T_base_camera;
  pose.linear() = StatedCamera(T_base_camera).tilt(state) * T_base_camera.linear();
  pose.translation().z() *= std::exp(state[I::LogHeight]);
  return pose;
}

SE2 corrected(const SE2& motion, double seconds, const CalibrationVector& state) {
  const double error = headingError(motion, seconds, state);
  const Eigen::Vector2d t =
      std::exp(state[I::LogScale]) * (Eigen::Rotation2Dd(0.5 * error) * motion.translation());
  return {t.x(), t.y(), motion.theta + error};
}

Eigen::Matrix3d correctionSlopes(const SE2& motion, double seconds,
                                 const CalibrationVector& state) {
  const SE2 m = corrected(motion, seconds, state);
  const Eigen::Vector3d by_heading(-0.5 * m.y, 0.5 * m.x, 1.0);
  Eigen::Matrix3d slopes;
  slopes << Eigen::Vector3d(m.x, m.y, 0.0), motion.theta * by_heading, seconds * by_heading;
  return slopes;
}

}  // namespace ipm_mapping::sweep

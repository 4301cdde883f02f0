#pragma once

#include <geometry_msgs/Pose.h>
#include <geometry_msgs/Transform.h>

#include <cmath>
#include <limits>

#include "ipm_mapping/geometry/se2.hpp"

namespace ipm_mapping {

/// Heading of a quaternion's x axis; its tilt is left out. Not a number where it is no unit
/// quaternion: nobody filled it in.
[[nodiscard]] inline double yawOf(const geometry_msgs::Quaternion& q) {
  const double norm2 = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
  if (!(std::abs(norm2 - 1.0) < 0.1)) return std::numeric_limits<double>::quiet_NaN();
  return std::atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z));
}

/// The part of a pose that lies on the floor.
[[nodiscard]] inline SE2 toSE2(const geometry_msgs::Pose& pose) {
  return {pose.position.x, pose.position.y, yawOf(pose.orientation)};
}
[[nodiscard]] inline SE2 toSE2(const geometry_msgs::Transform& transform) {
  return {transform.translation.x, transform.translation.y, yawOf(transform.rotation)};
}

/// A heading as quaternion.
[[nodiscard]] inline geometry_msgs::Quaternion toQuaternion(double yaw) {
  geometry_msgs::Quaternion q;
  q.z = std::sin(0.5 * yaw);
  q.w = std::cos(0.5 * yaw);
  return q;
}
/// A pose on the floor.
[[nodiscard]] inline geometry_msgs::Pose toPose(const SE2& pose) {
  geometry_msgs::Pose message;
  message.position.x = pose.x;
  message.position.y = pose.y;
  message.orientation = toQuaternion(pose.theta);
  return message;
}
[[nodiscard]] inline geometry_msgs::Transform toTransform(const SE2& pose) {
  geometry_msgs::Transform message;
  message.translation.x = pose.x;
  message.translation.y = pose.y;
  message.rotation = toQuaternion(pose.theta);
  return message;
}

}  // namespace ipm_mapping

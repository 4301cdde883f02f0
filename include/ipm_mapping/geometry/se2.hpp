#pragma once

#include <Eigen/Core>
#include <cmath>

namespace ipm_mapping {

/// Wraps an angle to [-pi, pi].
[[nodiscard]] inline double wrapAngle(double angle) { return std::remainder(angle, 2.0 * M_PI); }

/// A pose on the floor: `T_a_b` takes coordinates in b to coordinates in a. Metres and radians.
struct SE2 {
  double x = 0.0;
  double y = 0.0;
  double theta = 0.0;

  [[nodiscard]] Eigen::Vector2d translation() const { return {x, y}; }
  [[nodiscard]] double distance() const { return std::hypot(x, y); }

  /// T_a_b * p_b = p_a
  [[nodiscard]] Eigen::Vector2d operator*(const Eigen::Vector2d& p) const {
    const double c = std::cos(theta), s = std::sin(theta);
    return {c * p.x() - s * p.y() + x, s * p.x() + c * p.y() + y};
  }
  /// T_a_b * T_b_c = T_a_c
  [[nodiscard]] SE2 operator*(const SE2& other) const {
    const Eigen::Vector2d t = *this * other.translation();
    return {t.x(), t.y(), wrapAngle(theta + other.theta)};
  }
  [[nodiscard]] SE2 inverse() const {
    const double c = std::cos(theta), s = std::sin(theta);
    return {-c * x - s * y, s * x - c * y, -theta};
  }
  /// Homogeneous 3x3 matrix of the transform.
  [[nodiscard]] Eigen::Matrix3d matrix() const {
    const double c = std::cos(theta), s = std::sin(theta);
    Eigen::Matrix3d m;
    m << c, -s, x, s, c, y, 0, 0, 1;
    return m;
  }
  [[nodiscard]] bool finite() const {
    return std::isfinite(x) && std::isfinite(y) && std::isfinite(theta);
  }
};

/// Of the robot in its own axes: metres and radians per second.
struct Velocity {
  double x = 0.0;
  double y = 0.0;
  double theta = 0.0;

  [[nodiscard]] bool moving() const { return x != 0.0 || y != 0.0 || theta != 0.0; }
};

/// Pose on the straight line from `a` (at 0) to `b` (at 1), heading turned the short way round.
[[nodiscard]] inline SE2 interpolate(const SE2& a, const SE2& b, double t) {
  return {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y),
          wrapAngle(a.theta + t * wrapAngle(b.theta - a.theta))};
}

/// Velocity (x, y, theta), in the moving frame's own axes, that leads from identity to `pose` in
/// one unit of time along an arc: the group's logarithm, t = V^-1 translation,
///   V = (s, -c; c, s), s = sin(theta) / theta, c = (1 - cos(theta)) / theta.
[[nodiscard]] inline Eigen::Vector3d logarithm(const SE2& pose) {
  const double half = 0.5 * pose.theta;
  const double a = std::abs(half) < 1e-6 ? 1.0 - half * half / 3.0 : half / std::tan(half);
  return {a * pose.x + half * pose.y, a * pose.y - half * pose.x, pose.theta};
}

/// Where a constant velocity leads in one unit of time: the inverse of logarithm().
[[nodiscard]] inline SE2 exponential(const Eigen::Vector3d& velocity) {
  const double theta = velocity[2];
  const bool small = std::abs(theta) < 1e-6;
  const double s = small ? 1.0 - theta * theta / 6.0 : std::sin(theta) / theta;
  const double c = small ? 0.5 * theta : 2.0 * std::pow(std::sin(0.5 * theta), 2) / theta;
  return {s * velocity[0] - c * velocity[1], c * velocity[0] + s * velocity[1], wrapAngle(theta)};
}

/// Where a robot is that goes on from `pose` for so long.
[[nodiscard]] inline SE2 later(const SE2& pose, const Velocity& velocity, double seconds) {
  if (seconds == 0.0) return pose;
  return pose * exponential(seconds * Eigen::Vector3d(velocity.x, velocity.y, velocity.theta));
}

}  // namespace ipm_mapping

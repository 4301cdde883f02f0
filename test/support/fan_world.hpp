#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "ipm_mapping/detector.hpp"

namespace ipm_mapping::test {

/// Round obstacles on a floor, and the answers that a faultless detector gives of them: a fan of
/// bearings from the foot of the camera, each with the first obstacle in its direction.
struct FanWorld {
  struct Disc {
    Eigen::Vector2d centre;
    double radius;
  };
  static constexpr int bearings = 61;
  static constexpr double half_view = 0.6, max_range = 2.0, near = 0.45;

  std::vector<Disc> discs;
  double facing = 0.0;  // of the fan in base
  CameraModel camera{Intrinsics{640, 480, 525.0, 525.0, 319.5, 239.5}, {}};
  CameraPose T_base_camera = cameraPose(0.05, 0.0, 0.45, 0.42);

  [[nodiscard]] static double angle(int i) { return half_view * (1.0 - 2.0 * i / (bearings - 1)); }

  /// Distance from a place along a heading to the first disc; infinity where there is none.
  [[nodiscard]] double firstHit(const Eigen::Vector2d& from, double heading) const {
    double nearest = std::numeric_limits<double>::infinity();
    const Eigen::Vector2d ahead(std::cos(heading), std::sin(heading));
    for (const Disc& disc : discs) {
      const Eigen::Vector2d d = disc.centre - from;
      const double along = d.dot(ahead), across2 = d.squaredNorm() - along * along;
      const double half = disc.radius * disc.radius - across2;
      if (half >= 0.0 && along - std::sqrt(half) > 0.0)
        nearest = std::min(nearest, along - std::sqrt(half));
    }
    return nearest;
  }
  [[nodiscard]] Obstacles seenFrom(const SE2& T_odom_base, double stamp) const {
    Obstacles seen;
    seen.max_range = max_range;
    seen.view.stamp = stamp;
    seen.view.camera = camera;
    seen.view.T_base_camera = T_base_camera;
    seen.view.T_odom_base = T_odom_base;
    const Eigen::Vector2d foot = seen.view.cameraFoot();
    for (int i = 0; i < bearings; ++i) {
      const double direction = wrapAngle(facing + angle(i));
      const double hit = firstHit(T_odom_base * foot, T_odom_base.theta + direction);
      const Eigen::Vector2d ahead(std::cos(direction), std::sin(direction));
      const bool near_enough = (foot + hit * ahead).norm() <= max_range;
      Bearing bearing;
      bearing.angle = static_cast<float>(direction);
      bearing.near = static_cast<float>(near);
      bearing.range = static_cast<float>(near_enough ? hit : max_range - foot.norm());
      bearing.state = near_enough ? BearingState::Occupied : BearingState::Free;
      if (near_enough) {
        Contact contact;
        contact.bearing = i;
        contact.p_base = (foot + hit * ahead).cast<float>();
        contact.score = 20.0F;
        seen.contacts.push_back(contact);
      }
      seen.bearings.push_back(bearing);
    }
    return seen;
  }
};

}  // namespace ipm_mapping::test

#pragma once

#include <ipm_mapping/DifferenceImage.h>
#include <ipm_mapping/ObstacleArray.h>
#include <ipm_mapping/ObstacleMask.h>
#include <ros/time.h>

#include <string>

#include "ipm_mapping/obstacles.hpp"
#include "ipm_mapping/ros/images.hpp"

namespace ipm_mapping {

/// Names of the frames that a picture's geometry refers to.
struct FrameNames {
  std::string base;  ///< robot on the floor
  std::string odom;  ///< where odometry puts the robot
};

/// Seconds of a stamp and back, to the nanosecond where a double holds it.
[[nodiscard]] inline double seconds(const ros::Time& stamp) { return stamp.toSec(); }
[[nodiscard]] ros::Time rosTime(double seconds);

void toMessage(const GroundView& view, const FrameNames& frames, ViewGeometry& message);
/// Exact inverse of toMessage(): not one bit of the geometry changes. `stamp` is the message
/// header's. Refuses geometry that no camera can have.
[[nodiscard]] Refusal fromMessage(const ViewGeometry& message, const ros::Time& stamp,
                                  GroundView& view);

/// Windows onto the pictures of a message that outlives them.
[[nodiscard]] Refusal wrap(const DifferenceImage& message, GrayView& difference, GrayView& valid);
[[nodiscard]] Refusal wrap(const ObstacleMask& message, GrayView& mask);

/// Everything but the header's stamp and `detector`.
void toMessage(const Obstacles& obstacles, const FrameNames& frames, ObstacleArray& message);
/// Refuses geometry and states that do not exist; points that are not finite are passed on, the
/// map counts them.
[[nodiscard]] Refusal fromMessage(const ObstacleArray& message, Obstacles& obstacles);

}  // namespace ipm_mapping

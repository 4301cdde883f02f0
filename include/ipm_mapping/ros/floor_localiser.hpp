#pragma once

#include <tf2_ros/transform_broadcaster.h>

#include <string>

#include "ipm_mapping/parameters/node_parameters.hpp"
#include "ipm_mapping/ros/stage_messages.hpp"
#include "ipm_mapping/sweep/map_anchor.hpp"

namespace ipm_mapping {

/// tf from `map_frame` to the odometry's frame, as a localiser publishes it.
class FloorLocaliser {
 public:
  explicit FloorLocaliser(const FloorLocaliserParameters& parameters);

  void restart(Restart cause) { anchor_.restart(cause); }
  /// The two poses of a frame. Returns T_map_odom.
  SE2 publish(const SE2& T_odom_wheels, const SE2& T_odom_refined, const ros::Time& stamp,
              const FrameNames& frames);

 private:
  std::string map_frame_;
  ros::Duration tolerance_;
  sweep::MapAnchor anchor_;
  tf2_ros::TransformBroadcaster broadcaster_;
};

}  // namespace ipm_mapping

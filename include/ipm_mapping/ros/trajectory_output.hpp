#pragma once

#include <nav_msgs/Path.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <string>

#include "ipm_mapping/geometry/se2.hpp"

namespace ipm_mapping {

/// The robot's way through the map as nav_msgs/Path on `trajectory`; made only for subscribers.
class TrajectoryOutput {
 public:
  explicit TrajectoryOutput(ros::NodeHandle& node);

  /// Poses nearer than a few centimetres to the one before are left out.
  void add(const std::string& frame, const ros::Time& stamp, const SE2& T_odom_base);
  void clear() { path_.poses.clear(); }
  void publish();

 private:
  nav_msgs::Path path_;
  ros::Publisher publisher_;
  bool changed_ = false;
};

}  // namespace ipm_mapping

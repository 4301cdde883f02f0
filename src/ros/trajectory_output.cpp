#include "ipm_mapping/ros/trajectory_output.hpp"

#include <cmath>

#include "ipm_mapping/ros/poses.hpp"

namespace ipm_mapping {
namespace {

constexpr double step_metres = 0.02, step_radians = 0.05;
constexpr std::size_t longest = 20000;

}  // namespace

TrajectoryOutput::TrajectoryOutput(ros::NodeHandle& node)
    : publisher_(node.advertise<nav_msgs::Path>("trajectory", 1)) {}

void TrajectoryOutput::add(const std::string& frame, const ros::Time& stamp, const SE2& pose) {
  path_.header.frame_id = frame;
  path_.header.stamp = stamp;
  if (!path_.poses.empty()) {
    const auto& last = path_.poses.back().pose;
    const double turned =
        wrapAngle(2.0 * std::atan2(last.orientation.z, last.orientation.w) - pose.theta);
    const double moved = std::hypot(pose.x - last.position.x, pose.y - last.position.y);
    if (moved < step_metres && std::abs(turned) < step_radians) return;
  }
  if (path_.poses.size() == longest)
    path_.poses.erase(path_.poses.begin(), path_.poses.begin() + longest / 4);
  geometry_msgs::PoseStamped& stamped = path_.poses.emplace_back();
  stamped.header = path_.header;
  stamped.pose = toPose(pose);
  changed_ = true;
}

void TrajectoryOutput::publish() {
  if (!changed_ || publisher_.getNumSubscribers() == 0) return;
  publisher_.publish(path_);
  changed_ = false;
}

}  // namespace ipm_mapping

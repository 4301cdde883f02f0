#include "ipm_mapping/ros/floor_localiser.hpp"

#include <cmath>

#include "ipm_mapping/ros/odometry_source.hpp"

namespace ipm_mapping {

FloorLocaliser::FloorLocaliser(const FloorLocaliserParameters& parameters)
    : map_frame_(withoutSlash(parameters.map_frame)), tolerance_(parameters.transform_tolerance) {
  if (active()) broadcaster_.emplace();
}

SE2 FloorLocaliser::publish(const SE2& T_odom_wheels, const SE2& T_odom_refined,
                            const ros::Time& stamp, const FrameNames& frames) {
  const SE2 T_map_odom = anchor_.follow(T_odom_wheels, T_odom_refined);
  if (!active()) return T_map_odom;
  geometry_msgs::TransformStamped message;
  message.header.stamp = stamp + tolerance_;
  message.header.frame_id = map_frame_;
  message.child_frame_id = frames.odom;
  message.transform.translation.x = T_map_odom.x;
  message.transform.translation.y = T_map_odom.y;
  message.transform.rotation.z = std::sin(0.5 * T_map_odom.theta);
  message.transform.rotation.w = std::cos(0.5 * T_map_odom.theta);
  broadcaster_->sendTransform(message);
  return T_map_odom;
}

}  // namespace ipm_mapping

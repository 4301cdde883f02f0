#include "ipm_mapping/ros/floor_localiser.hpp"

#include "ipm_mapping/ros/odometry_source.hpp"
#include "ipm_mapping/ros/poses.hpp"

namespace ipm_mapping {

FloorLocaliser::FloorLocaliser(const FloorLocaliserParameters& parameters)
    : map_frame_(withoutSlash(parameters.map_frame)), tolerance_(parameters.transform_tolerance) {}

SE2 FloorLocaliser::publish(const SE2& T_odom_wheels, const SE2& T_odom_refined,
                            const ros::Time& stamp, const FrameNames& frames) {
  const SE2 T_map_odom = anchor_.follow(T_odom_wheels, T_odom_refined);
  geometry_msgs::TransformStamped message;
  message.header.stamp = stamp + tolerance_;
  message.header.frame_id = map_frame_;
  message.child_frame_id = frames.odom;
  message.transform = toTransform(T_map_odom);
  broadcaster_.sendTransform(message);
  return T_map_odom;
}

}  // namespace ipm_mapping

#include "ipm_mapping/ros/refined_odometry.hpp"

#include <array>
#include <boost/make_shared.hpp>

#include "ipm_mapping/detectors/floor_observation.hpp"
#include "ipm_mapping/ros/poses.hpp"

namespace ipm_mapping {
namespace {

constexpr double least_variance = 1e-6;  // m^2, rad^2 and the same by s^2

/// Of (x, y, theta) as message: x, y, z, roll, pitch, yaw, row by row.
template <class Covariance>
void toMessage(const Eigen::Matrix3d& covariance, Covariance& message) {
  constexpr std::array<std::size_t, 3> place{0, 1, 5};
  message.assign(0.0);
  for (std::size_t i = 0; i < 6; ++i) message[7 * i] = least_variance;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      message[6 * place[i] + place[j]] +=
          covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
}

}  // namespace

void toMessage(const sweep::FloorPose& pose, const FrameNames& frames,
               nav_msgs::Odometry& message) {
  message.header.frame_id = frames.odom;
  message.child_frame_id = frames.base;
  message.pose.pose = toPose(pose.T_odom_base);
  toMessage(pose.covariance, message.pose.covariance);
  message.twist.twist.linear.x = pose.velocity.x();
  message.twist.twist.linear.y = pose.velocity.y();
  message.twist.twist.angular.z = pose.velocity.z();
  toMessage(pose.velocity_covariance, message.twist.covariance);
}

RefinedOdometry::RefinedOdometry(ros::NodeHandle& node, LazyOutputs& outputs,
                                 const Parameters& parameters)
    : odometry_(parameters.sweep, parameters.floor_odometry),
      publisher_(outputs.advertise<nav_msgs::Odometry>(node, "odom_refined")) {}

void RefinedOdometry::setParameters(const Parameters& parameters) {
  odometry_.configure(parameters.sweep, parameters.floor_odometry);
}

const SE2& RefinedOdometry::follow(const Detector& detector, const Frame& frame, FrameStatus status,
                                   const ros::Time& stamp, const FrameNames& frames) {
  const sweep::FloorPose& pose = odometry_.add(floorObservation(detector, frame, status));
  if (publisher_.getNumSubscribers() > 0) {
    auto message = boost::make_shared<nav_msgs::Odometry>();
    message->header.stamp = stamp;
    toMessage(pose, frames, *message);
    publisher_.publish(message);
  }
  return pose.T_odom_base;
}

}  // namespace ipm_mapping

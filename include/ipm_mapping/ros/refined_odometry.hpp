#pragma once

#include <nav_msgs/Odometry.h>

#include "ipm_mapping/detector.hpp"
#include "ipm_mapping/parameters.hpp"
#include "ipm_mapping/ros/lazy_outputs.hpp"
#include "ipm_mapping/ros/stage_messages.hpp"
#include "ipm_mapping/sweep/floor_odometry.hpp"

namespace ipm_mapping {

/// Pose and velocity on the floor as message; its stamp is the caller's. Pose in `frames.odom`,
/// velocity in `frames.base`. No variance is below that of a millimetre and a milliradian, also of
/// z, roll and pitch, which the floor fixes: filters invert these matrices.
void toMessage(const sweep::FloorPose& pose, const FrameNames& frames, nav_msgs::Odometry& message);

/// The topic `odom_refined`. Follows every frame, so that its state is right whenever somebody
/// starts to listen.
class RefinedOdometry {
 public:
  RefinedOdometry(ros::NodeHandle& node, LazyOutputs& outputs, const Parameters& parameters);

  /// Goes on from the present pose.
  void setParameters(const Parameters& parameters);
  void reset() { odometry_.reset(); }
  /// After the detector has processed the frame. Returns the refined pose.
  const SE2& follow(const Detector& detector, const Frame& frame, FrameStatus status,
                    const ros::Time& stamp, const FrameNames& frames);

 private:
  sweep::FloorOdometry odometry_;
  ros::Publisher publisher_;
};

}  // namespace ipm_mapping

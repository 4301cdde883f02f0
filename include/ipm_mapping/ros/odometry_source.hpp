#pragma once

#include <nav_msgs/Odometry.h>
#include <ros/node_handle.h>
#include <ros/subscriber.h>
#include <tf2/buffer_core.h>
#include <tf2_msgs/TFMessage.h>

#include <functional>

#include "ipm_mapping/geometry/se2.hpp"
#include "ipm_mapping/parameters/node_parameters.hpp"
#include "ipm_mapping/ros/stage_messages.hpp"

namespace ipm_mapping {

/// Robot poses over time, from nav_msgs/Odometry on `odom` or from tf.
class OdometrySource {
 public:
  using Handler = std::function<void(double stamp, const SE2& T_odom_base)>;

  /// `tf` is cleared when the time of its poses was set back.
  OdometrySource(ros::NodeHandle& node, tf2::BufferCore& tf, const SourceParameters& parameters,
                 Handler handler);

  void start();
  void stop() { subscriber_.shutdown(); }
  /// Names of the frames: the parameters' where they are given, else those of the messages; empty
  /// until one came.
  [[nodiscard]] std::string topic() const { return subscriber_.getTopic(); }
  [[nodiscard]] const FrameNames& frames() const { return frames_; }

 private:
  void name(const std::string& base, const std::string& odom);
  void onOdometry(const nav_msgs::OdometryConstPtr& odometry);
  void onTf(const tf2_msgs::TFMessageConstPtr& message);
  [[nodiscard]] bool setBack(const tf2_msgs::TFMessage& message) const;

  ros::NodeHandle node_;
  tf2::BufferCore& tf_;
  SourceParameters parameters_;
  Handler handler_;
  ros::Subscriber subscriber_;
  FrameNames frames_;
  ros::Time last_tf_;
};

/// Frame names of tf have no slash in front; those of old drivers do.
[[nodiscard]] inline std::string withoutSlash(const std::string& frame) {
  return frame.compare(0, 1, "/") == 0 ? frame.substr(1) : frame;
}

}  // namespace ipm_mapping

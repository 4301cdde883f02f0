#include "ipm_mapping/ros/odometry_source.hpp"

#include <tf2/exceptions.h>

#include <algorithm>
#include <utility>

#include "ipm_mapping/ros/header_stamp.hpp"
#include "ipm_mapping/ros/poses.hpp"

namespace ipm_mapping {
namespace {

constexpr int queue_length = 500;
constexpr double clock_jump = 1.0;  // seconds

std::string firstGiven(const std::string& a, const std::string& b, const char* c) {
  return !a.empty() ? a : !b.empty() ? b : c;
}

}  // namespace

OdometrySource::OdometrySource(ros::NodeHandle& node, tf2::BufferCore& tf,
                               const SourceParameters& parameters, Handler handler)
    : node_(node), tf_(tf), parameters_(parameters), handler_(std::move(handler)) {
  frames_ = {withoutSlash(parameters.base_frame), withoutSlash(parameters.odom_frame)};
  if (parameters.odometry_source == PoseOrigin::Tf) name("", "");
}

void OdometrySource::start() {
  const auto hints = ros::TransportHints().tcpNoDelay();
  if (parameters_.odometry_source == PoseOrigin::Tf)
    subscriber_ = node_.subscribe("/tf", queue_length, &OdometrySource::onTf, this, hints);
  else
    subscriber_ = node_.subscribe("odom", queue_length, &OdometrySource::onOdometry, this, hints);
}

void OdometrySource::name(const std::string& base, const std::string& odom) {
  frames_.base = withoutSlash(firstGiven(parameters_.base_frame, base, "base_footprint"));
  frames_.odom = withoutSlash(firstGiven(parameters_.odom_frame, odom, "odom"));
}

void OdometrySource::onOdometry(const nav_msgs::OdometryConstPtr& odometry) {
  name(odometry->child_frame_id, odometry->header.frame_id);
  handler_(stampOf(odometry->header), toSE2(odometry->pose.pose));
}

/// Poses far older than the newest one: a bag began anew, or the robot's clock did.
bool OdometrySource::setBack(const tf2_msgs::TFMessage& message) const {
  const auto old = [&](const geometry_msgs::TransformStamped& transform) {
    const bool pose = withoutSlash(transform.header.frame_id) == frames_.odom ||
                      withoutSlash(transform.child_frame_id) == frames_.base;
    return pose && !transform.header.stamp.isZero() &&
           (last_tf_ - transform.header.stamp).toSec() > clock_jump;
  };
  return std::any_of(message.transforms.begin(), message.transforms.end(), old);
}

/// One message of before that arrives late would keep tf from taking all that is ten seconds older.
void OdometrySource::onTf(const tf2_msgs::TFMessageConstPtr& message) {
  if (setBack(*message)) {
    tf_.clear();
    last_tf_ = ros::Time();
    for (const auto& transform : message->transforms) tf_.setTransform(transform, "tf");
  }
  if (!tf_.canTransform(frames_.odom, frames_.base, ros::Time(0))) return;
  try {
    const auto pose = tf_.lookupTransform(frames_.odom, frames_.base, ros::Time(0));
    if (pose.header.stamp == last_tf_) return;
    last_tf_ = pose.header.stamp;
    handler_(last_tf_.toSec(), toSE2(pose.transform));
  } catch (const tf2::TransformException&) {
    return;  // the next message may complete the chain
  }
}

}  // namespace ipm_mapping

#include "ros/messages.hpp"

#include <algorithm>
#include <cmath>

namespace ipm_mapping::sim {
namespace {

constexpr double kMapMargin = 1.0;

geometry_msgs::Quaternion quaternion(const Eigen::Quaterniond& q) {
  geometry_msgs::Quaternion message;
  message.x = q.x();
  message.y = q.y();
  message.z = q.z();
  message.w = q.w();
  return message;
}

geometry_msgs::Quaternion heading(double theta) {
  return quaternion(Eigen::Quaterniond(Eigen::AngleAxisd(theta, Eigen::Vector3d::UnitZ())));
}

/// Variances of x, y and yaw as a TurtleBot's base reports them while driving; the other three
/// degrees of freedom are not measured.
template <class Covariance>
void setCovariance(Covariance& covariance) {
  covariance.assign(0.0);
  covariance[0] = covariance[7] = 0.01;
  covariance[14] = covariance[21] = covariance[28] = 1e6;
  covariance[35] = 0.01;
}

}  // namespace

ros::Time stampOf(const Scene& scene, double time) {
  const double seconds = std::floor(scene.start_stamp);
  ros::Time stamp(static_cast<std::uint32_t>(seconds), 0);
  const double rest = scene.start_stamp - seconds + time;
  ros::Duration offset;
  offset.fromNSec(static_cast<std::int64_t>(std::llround(rest * 1e9)));
  return stamp + offset;
}

sensor_msgs::Image imageMessage(const Scene& scene, ros::Time stamp,
                                std::vector<std::uint8_t>&& grey) {
  sensor_msgs::Image image;
  image.header.stamp = stamp;
  image.header.frame_id = kOpticalFrame;
  image.width = static_cast<std::uint32_t>(scene.camera.width);
  image.height = static_cast<std::uint32_t>(scene.camera.height);
  image.encoding = "mono8";
  image.step = image.width;
  image.data = std::move(grey);
  return image;
}

sensor_msgs::CameraInfo cameraInfoMessage(const Scene& scene, ros::Time stamp) {
  const CameraSpec& c = scene.camera;
  sensor_msgs::CameraInfo info;
  info.header.stamp = stamp;
  info.header.frame_id = kOpticalFrame;
  info.width = static_cast<std::uint32_t>(c.width);
  info.height = static_cast<std::uint32_t>(c.height);
  info.distortion_model = "plumb_bob";
  info.D = c.distortion;
  info.D.resize(5, 0.0);
  info.K = {c.fx, 0.0, c.cx, 0.0, c.fy, c.cy, 0.0, 0.0, 1.0};
  info.R = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
  info.P = {c.fx, 0.0, c.cx, 0.0, 0.0, c.fy, c.cy, 0.0, 0.0, 0.0, 1.0, 0.0};
  return info;
}

nav_msgs::Odometry odometryMessage(const SE2& pose, const Command& speed, ros::Time stamp,
                                   const std::string& parent) {
  nav_msgs::Odometry odometry;
  odometry.header.stamp = stamp;
  odometry.header.frame_id = parent;
  odometry.child_frame_id = kBaseFrame;
  odometry.pose.pose.position.x = pose.x;
  odometry.pose.pose.position.y = pose.y;
  odometry.pose.pose.orientation = heading(pose.theta);
  odometry.twist.twist.linear.x = speed.v;
  odometry.twist.twist.angular.z = speed.w;
  setCovariance(odometry.pose.covariance);
  setCovariance(odometry.twist.covariance);
  return odometry;
}

geometry_msgs::TransformStamped transformOf(const nav_msgs::Odometry& odometry) {
  geometry_msgs::TransformStamped transform;
  transform.header = odometry.header;
  transform.child_frame_id = odometry.child_frame_id;
  transform.transform.translation.x = odometry.pose.pose.position.x;
  transform.transform.translation.y = odometry.pose.pose.position.y;
  transform.transform.rotation = odometry.pose.pose.orientation;
  return transform;
}

geometry_msgs::TransformStamped cameraTransform(const Scene& scene, ros::Time stamp) {
  const CameraPose pose = statedPose(scene.camera);
  geometry_msgs::TransformStamped transform;
  transform.header.stamp = stamp;
  transform.header.frame_id = kBaseFrame;
  transform.child_frame_id = kOpticalFrame;
  transform.transform.translation.x = pose.translation().x();
  transform.transform.translation.y = pose.translation().y();
  transform.transform.translation.z = pose.translation().z();
  transform.transform.rotation = quaternion(Eigen::Quaterniond(pose.rotation()));
  return transform;
}

nav_msgs::OccupancyGrid trueMap(const std::vector<Footprint>& footprints, double resolution,
                                ros::Time stamp) {
  Point low = Point::Constant(-kMapMargin), high = Point::Constant(kMapMargin);
  for (const Footprint& footprint : footprints) {
    for (const Point& p : footprint.points) {
      low = low.cwiseMin(p - Point::Constant(kMapMargin));
      high = high.cwiseMax(p + Point::Constant(kMapMargin));
    }
  }
  low = (low / resolution).array().floor() * resolution;
  nav_msgs::OccupancyGrid map;
  map.header.stamp = map.info.map_load_time = stamp;
  map.header.frame_id = kWorldFrame;
  map.info.resolution = static_cast<float>(resolution);
  map.info.width = static_cast<std::uint32_t>(std::ceil((high.x() - low.x()) / resolution));
  map.info.height = static_cast<std::uint32_t>(std::ceil((high.y() - low.y()) / resolution));
  map.info.origin.position.x = low.x();
  map.info.origin.position.y = low.y();
  map.info.origin.orientation.w = 1.0;
  for (std::uint32_t j = 0; j < map.info.height; ++j) {
    for (std::uint32_t i = 0; i < map.info.width; ++i) {
      const Point centre = low + resolution * Point(i + 0.5, j + 0.5);
      const bool occupied =
          std::any_of(footprints.begin(), footprints.end(), [&](const Footprint& footprint) {
            return footprint.height >= kObstacleHeight && footprint.way.empty() &&
                   distanceTo(footprint, centre, 0.0) <= 0.5 * resolution;
          });
      map.data.push_back(occupied ? 100 : 0);
    }
  }
  return map;
}

}  // namespace ipm_mapping::sim

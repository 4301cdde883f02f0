#pragma once
// A robot that drives towards a box on a mottled floor, as messages: small, and made in the test.

#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>

#include <Eigen/Geometry>
#include <boost/make_shared.hpp>
#include <cmath>
#include <cstdint>
#include <vector>

#include "ipm_mapping/geometry/camera.hpp"
#include "ipm_mapping/geometry/se2.hpp"

namespace ipm_mapping {

class SyntheticRobot {
 public:
  static constexpr int width = 320, height = 240;
  static constexpr double frame_period = 0.1, odometry_period = 0.02, first_stamp = 1000.0;
  static constexpr const char* base_frame = "base_footprint";
  static constexpr const char* odom_frame = "odom";
  static constexpr const char* camera_frame = "camera_optical";

  /// Sequence number of every header. Serialising a message overwrites it, handing over a pointer
  /// does not.
  static constexpr std::uint32_t marked_seq = 4711;

  int frames = 20;

  [[nodiscard]] static Intrinsics intrinsics() { return {width, height, 260, 260, 159.5, 119.5}; }
  [[nodiscard]] static CameraPose T_base_camera() { return cameraPose(0.05, 0.0, 0.45, 0.42); }
  /// Straight on for a while, then a gentle curve.
  [[nodiscard]] static SE2 pose(double t) {
    const double curve = std::max(0.0, t - 0.8);
    return {0.53 * t, 0.05 * curve * curve, 0.2 * curve};
  }
  /// Times of the frames and of the odometry: five messages a frame, the first at its stamp.
  [[nodiscard]] static double frameTime(int i) { return odometryTime(5 * i); }
  [[nodiscard]] static double odometryTime(int k) { return k * odometry_period; }

  [[nodiscard]] static sensor_msgs::CameraInfo cameraInfo(double stamp) {
    sensor_msgs::CameraInfo info;
    info.header = header(stamp, camera_frame);
    info.width = width;
    info.height = height;
    info.distortion_model = "plumb_bob";
    info.D.assign(5, 0.0);
    const Intrinsics k = intrinsics();
    info.K = {k.fx, 0, k.cx, 0, k.fy, k.cy, 0, 0, 1};
    return info;
  }

  [[nodiscard]] static nav_msgs::Odometry odometry(double stamp, const SE2& pose) {
    nav_msgs::Odometry message;
    message.header = header(stamp, odom_frame);
    message.child_frame_id = base_frame;
    message.pose.pose.position.x = pose.x;
    message.pose.pose.position.y = pose.y;
    message.pose.pose.orientation.z = std::sin(0.5 * pose.theta);
    message.pose.pose.orientation.w = std::cos(0.5 * pose.theta);
    return message;
  }

  [[nodiscard]] static geometry_msgs::TransformStamped cameraTransform() {
    geometry_msgs::TransformStamped message;
    message.header = header(first_stamp, base_frame);
    message.child_frame_id = camera_frame;
    const CameraPose T = T_base_camera();
    const Eigen::Quaterniond q(T.linear());
    message.transform.translation.x = T.translation().x();
    message.transform.translation.y = T.translation().y();
    message.transform.translation.z = T.translation().z();
    message.transform.rotation.x = q.x();
    message.transform.rotation.y = q.y();
    message.transform.rotation.z = q.z();
    message.transform.rotation.w = q.w();
    return message;
  }

  /// A box on the floor of odom, metres.
  struct Box {
    Eigen::Vector3d low, high;
  };
  /// What the robot drives towards, and somebody who may stand to the left of it.
  [[nodiscard]] static Box box() { return {{1.5, -0.25, 0.0}, {1.8, 0.15, 0.4}}; }
  [[nodiscard]] static Box visitor() { return {{1.7, 0.45, 0.0}, {1.82, 0.7, 0.9}}; }

  [[nodiscard]] static sensor_msgs::ImagePtr image(double stamp, const SE2& T_odom_base,
                                                   bool visited = false) {
    auto message = boost::make_shared<sensor_msgs::Image>();
    message->header = header(stamp, camera_frame);
    message->width = width;
    message->height = height;
    message->encoding = "mono8";
    message->step = width;
    message->data.resize(static_cast<std::size_t>(width) * height);
    Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
    T_world_camera.linear() =
        Eigen::AngleAxisd(T_odom_base.theta, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    T_world_camera.translation() = Eigen::Vector3d(T_odom_base.x, T_odom_base.y, 0.0);
    T_world_camera = T_world_camera * T_base_camera();
    for (int v = 0; v < height; ++v)
      for (int u = 0; u < width; ++u)
        message->data[static_cast<std::size_t>(v * width + u)] =
            shade(T_world_camera, u, v, visited);
    return message;
  }

 private:
  static std_msgs::Header header(double stamp, const char* frame) {
    std_msgs::Header h;
    h.stamp.fromSec(stamp);
    h.frame_id = frame;
    h.seq = marked_seq;
    return h;
  }

  static double hash(int x, int y, int z) {
    auto h = static_cast<std::uint32_t>(x * 374761393 + y * 668265263 + z * 2147483647);
    h = (h ^ (h >> 13U)) * 1274126177U;
    return static_cast<double>((h ^ (h >> 16U)) & 0xFFFFU) / 65535.0;
  }
  /// Smooth noise with a grain of 1 unit.
  static double noise(double x, double y, int z) {
    const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
    const double a = x - i, b = y - j;
    return (1 - a) * (1 - b) * hash(i, j, z) + a * (1 - b) * hash(i + 1, j, z) +
           (1 - a) * b * hash(i, j + 1, z) + a * b * hash(i + 1, j + 1, z);
  }

  /// Distance along the ray to the box; infinity where it is missed.
  static double toBox(const Box& box, const Eigen::Vector3d& from, const Eigen::Vector3d& ray) {
    const auto& [low, high] = box;
    double enter = 0.0, leave = 1e9;
    for (int i = 0; i < 3; ++i) {
      const double a = (low(i) - from(i)) / ray(i), b = (high(i) - from(i)) / ray(i);
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    return enter < leave ? enter : std::numeric_limits<double>::infinity();
  }

  static std::uint8_t shade(const Eigen::Isometry3d& T_world_camera, int u, int v, bool visited) {
    const Intrinsics k = intrinsics();
    const Eigen::Vector3d ray =
        T_world_camera.linear() * Eigen::Vector3d((u - k.cx) / k.fx, (v - k.cy) / k.fy, 1.0);
    const Eigen::Vector3d from = T_world_camera.translation();
    double nearest = toBox(box(), from, ray);
    if (visited) nearest = std::min(nearest, toBox(visitor(), from, ray));
    const double floor =
        ray.z() < 0 ? -from.z() / ray.z() : std::numeric_limits<double>::infinity();
    if (!std::isfinite(std::min(nearest, floor))) return 200;
    const Eigen::Vector3d p = from + std::min(nearest, floor) * ray;
    if (nearest < floor)
      return static_cast<std::uint8_t>(20 + 60 * noise(30 * (p.x() + p.y()), 30 * p.z(), 1));
    return static_cast<std::uint8_t>(130 + 40 * noise(8 * p.x(), 8 * p.y(), 2));
  }
};

}  // namespace ipm_mapping

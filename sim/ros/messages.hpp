#pragma once
// The simulated robot's messages, the same in a bag and live.

#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/OccupancyGrid.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>

#include "ipm_mapping_sim/simulation.hpp"

namespace ipm_mapping::sim {

inline constexpr const char* kOpticalFrame = "camera_rgb_optical_frame";
inline constexpr const char* kBaseFrame = "base_footprint";
inline constexpr const char* kOdomFrame = "odom";
inline constexpr const char* kWorldFrame = "world";

ros::Time stampOf(const Scene& scene, double time);

/// mono8 image; takes the grey levels over.
sensor_msgs::Image imageMessage(const Scene& scene, ros::Time stamp,
                                std::vector<std::uint8_t>&& grey);
sensor_msgs::CameraInfo cameraInfoMessage(const Scene& scene, ros::Time stamp);
nav_msgs::Odometry odometryMessage(const SE2& pose, const Command& speed, ros::Time stamp,
                                   const std::string& parent);
geometry_msgs::TransformStamped transformOf(const nav_msgs::Odometry& odometry);
/// Stated pose of the camera on the robot.
geometry_msgs::TransformStamped cameraTransform(const Scene& scene, ros::Time stamp);

/// Cells whose centre is within half a cell of, or inside, anything that is taller than 1.5 cm on
/// the floor are 100, the others 0.
nav_msgs::OccupancyGrid trueMap(const std::vector<Footprint>& footprints, double resolution,
                                ros::Time stamp);

}  // namespace ipm_mapping::sim

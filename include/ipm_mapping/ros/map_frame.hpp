#pragma once

#include <ros/node_handle.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include <optional>
#include <string>

#include "ipm_mapping/geometry/se2.hpp"
#include "ipm_mapping/parameters/node_parameters.hpp"
#include "ipm_mapping/ros/images.hpp"

namespace ipm_mapping {

/// The frame in which the map is made: the odometry's own, or `global_frame`, in which a localiser
/// places the odometry's by tf.
class MapFrame {
 public:
  /// Listens to tf only when there is a global frame.
  MapFrame(ros::NodeHandle& node, const MapperParameters& parameters);

  /// What the map is in: the parameters' until the first answer came.
  [[nodiscard]] const std::string& name() const { return name_; }
  /// A localiser may move the odometry's frame.
  [[nodiscard]] bool moves() const { return !global_frame_.empty(); }
  /// Where `odom_frame` lies in the map at a stamp: there, or the newest that tf has. A refusal
  /// while tf does not know it, and, unless the map is `empty`, for another frame than before.
  [[nodiscard]] Refusal place(const std::string& odom_frame, const ros::Time& stamp, bool empty,
                              SE2& T_map_odom);

 private:
  [[nodiscard]] std::optional<SE2> find(const std::string& odom_frame,
                                        const ros::Time& stamp) const;

  std::string global_frame_, name_;
  tf2_ros::Buffer tf_;
  std::optional<tf2_ros::TransformListener> listener_;
};

}  // namespace ipm_mapping

#pragma once

#include <nav_msgs/OccupancyGrid.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <Eigen/Core>

#include <string>

#include "ipm_mapping/mapping/occupancy_map.hpp"
#include "ipm_mapping/parameters/node_parameters.hpp"

namespace ipm_mapping {

/// The map's topics: `map` (trinary, latched) and `map_probability` as a whole, `map_updates`
/// inside the geometry of the last `map`. Who subscribes late gets the present map, not the last
/// one that was published.
class MapOutputs {
 public:
  MapOutputs(ros::NodeHandle& node, OccupancyMap& map, const MapperParameters& parameters);

  /// Frame and stamp of what is published next.
  void setHeader(const std::string& frame, const ros::Time& stamp);
  /// Where the robot is, in the map's frame: the unknown map that stands in while nothing was seen
  /// lies around it.
  void setRobot(const Eigen::Vector2d& place) { robot_ = place; }
  /// Publishes what changed since the last call.
  void publishChanges();
  /// Publishes everything: at the start, after a reset.
  void publishAll();

 private:
  enum class Values { Trinary, Probability };
  [[nodiscard]] nav_msgs::OccupancyGridPtr grid(Values values) const;
  void publishUpdate(const MapRectangle& changed);
  void greet(const ros::SingleSubscriberPublisher& newcomer, Values values) const;

  OccupancyMap& map_;
  double full_map_period_;
  Eigen::Vector2d robot_ = Eigen::Vector2d::Zero();
  std_msgs::Header header_;
  ros::Publisher map_publisher_, probability_publisher_, updates_publisher_;
  std::uint64_t published_revision_ = 0;
  bool stale_ = false;  ///< the last `map` is older than the last update
  ros::WallTime last_full_map_;
};

}  // namespace ipm_mapping

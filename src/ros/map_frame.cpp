#include "ipm_mapping/ros/map_frame.hpp"

#include <tf2/exceptions.h>

#include "ipm_mapping/ros/odometry_source.hpp"
#include "ipm_mapping/ros/poses.hpp"
#include "ipm_mapping/ros/sentence.hpp"

namespace ipm_mapping {

MapFrame::MapFrame(ros::NodeHandle& node, const MapperParameters& parameters)
    : global_frame_(withoutSlash(parameters.global_frame)),
      name_(moves() ? global_frame_ : parameters.frame) {
  if (!moves()) return;
  listener_.emplace(tf_, node, false);
  tf_.setUsingDedicatedThread(true);
}

Refusal MapFrame::place(const std::string& odom_frame, const ros::Time& stamp, bool empty,
                        SE2& T_map_odom) {
  if (moves()) {
    const auto found = find(odom_frame, stamp);
    if (!found) return sentence("tf does not know '", odom_frame, "' in '", name_, "'");
    T_map_odom = *found;
    return std::nullopt;
  }
  if (!empty && odom_frame != name_)
    return sentence("obstacles are in '", odom_frame, "', the map is in '", name_, "'");
  name_ = odom_frame;
  T_map_odom = {};
  return std::nullopt;
}

std::optional<SE2> MapFrame::find(const std::string& odom_frame, const ros::Time& stamp) const {
  if (odom_frame == name_) return SE2{};
  // A localiser speaks now and then: what it said last holds until it speaks again.
  for (const ros::Time& time : {stamp, ros::Time(0)}) {
    try {
      return toSE2(tf_.lookupTransform(name_, odom_frame, time).transform);
    } catch (const tf2::TransformException&) {
      continue;
    }
  }
  return std::nullopt;
}

}  // namespace ipm_mapping

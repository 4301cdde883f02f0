#pragma once

#include <string>

#include "ipm_mapping/obstacles.hpp"
#include "ipm_mapping/parameters/robot_parameters.hpp"
#include "ipm_mapping/ros/lazy_outputs.hpp"
#include "ipm_mapping/ros/stage_messages.hpp"

namespace ipm_mapping {

/// The topics that every detector publishes: `obstacles`, `scan`, `contacts`, `free`. All in the
/// base frame, all at the stamp of the image; each is made only for subscribers.
class ObstacleOutputs {
 public:
  ObstacleOutputs(ros::NodeHandle& node, LazyOutputs& outputs, const OutputParameters& parameters);

  void publish(const Obstacles& obstacles, const ros::Time& stamp, const FrameNames& frames,
               const std::string& detector) const;
  void setParameters(const OutputParameters& parameters) { parameters_ = parameters; }

 private:
  OutputParameters parameters_;
  ros::Publisher obstacles_, scan_, contacts_, free_;
};

}  // namespace ipm_mapping

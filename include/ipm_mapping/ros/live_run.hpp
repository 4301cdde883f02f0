#pragma once

#include <string>

#include "ipm_mapping/detector.hpp"
#include "ipm_mapping/ros/offline_run.hpp"

namespace ipm_mapping {

/// How a tool listens to a robot.
struct LiveOptions {
  std::string image_transport = "raw";
  double seconds = 60.0;  ///< wall time
};

/// Lets a detector see live topics, until the time is over or the user interrupts; topics, pose and
/// parameters from `options` (its bag is not looked at). Throws BagError without a master or where
/// no frame came through. Returns where the camera's pose came from.
std::string runLive(const std::string& node_name, const OfflineOptions& options,
                    const LiveOptions& live, Detector& detector);

}  // namespace ipm_mapping

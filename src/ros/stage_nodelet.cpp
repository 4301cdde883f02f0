#include "ipm_mapping/ros/stage_nodelet.hpp"

#include "ipm_mapping/ros/wiring.hpp"

namespace ipm_mapping {

void StageNodelet::onInit() {
  starter_ = node().createWallTimer(
      ros::WallDuration(0.001), [this](const ros::WallTimerEvent&) { startOrStayIdle(); }, true);
}

void StageNodelet::startOrStayIdle() {
  try {
    const auto lock = wiringLock();
    monitor_ = std::make_unique<StageMonitor>(node(), privateNode(), getName());
    start();
  } catch (const std::exception& error) {
    if (monitor_)
      monitor_->cannotStart(error.what());
    else
      NODELET_FATAL("%s: cannot start and stays idle: %s", getName().c_str(), error.what());
  }
}

}  // namespace ipm_mapping

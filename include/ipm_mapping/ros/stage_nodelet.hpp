#pragma once

#include <nodelet/nodelet.h>

#include <memory>

#include "ipm_mapping/ros/stage_monitor.hpp"

namespace ipm_mapping {

/// A nodelet that cannot take its manager down: it starts on its own callback queue, so that
/// nothing of it ever runs twice at a time, and what goes wrong at the start is said once and
/// leaves it idle.
class StageNodelet : public nodelet::Nodelet {
 protected:
  /// Subscribes and advertises; may throw.
  virtual void start() = 0;

  [[nodiscard]] ros::NodeHandle& node() { return getNodeHandle(); }
  [[nodiscard]] ros::NodeHandle& privateNode() { return getPrivateNodeHandle(); }
  [[nodiscard]] StageMonitor& monitor() { return *monitor_; }

  /// Does `work`; what it throws is a dropped message.
  template <class Work>
  void guarded(Work&& work) {
    try {
      work();
    } catch (const std::exception& error) {
      monitor_->dropped("exception", error.what());
    }
  }
  /// Does `work` again and again, in wall time: also after a simulated clock has stopped.
  template <class Work>
  void every(double seconds, ros::WallTimer& timer, Work work) {
    timer = node().createWallTimer(ros::WallDuration(seconds),
                                   [this, work](const ros::WallTimerEvent&) { guarded(work); });
  }

 private:
  void onInit() final;
  void startOrStayIdle();

  std::unique_ptr<StageMonitor> monitor_;
  ros::WallTimer starter_;
};

}  // namespace ipm_mapping

#pragma once

#include <ros/time.h>

namespace ipm_mapping {

enum class StampVerdict {
  Next,  ///< newer than everything before
  Late,  ///< a little older or the same: drop it
  Jump   ///< the clock was set back, as by a bag that loops: forget what was before
};

/// Tells late messages from clocks that were set back.
class StampOrder {
 public:
  StampVerdict judge(const ros::Time& stamp) {
    const bool first = last_.isZero();
    const double step = (stamp - last_).toSec();
    if (!first && step <= 0.0 && step > -clock_jump_seconds) return StampVerdict::Late;
    last_ = stamp;
    return first || step > 0.0 ? StampVerdict::Next : StampVerdict::Jump;
  }
  void forget() { last_ = ros::Time(); }

 private:
  static constexpr double clock_jump_seconds = 1.0;
  ros::Time last_;
};

}  // namespace ipm_mapping

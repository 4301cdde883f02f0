#pragma once

#include "ipm_mapping/detector.hpp"
#include "ipm_mapping/geometry/se2.hpp"

namespace ipm_mapping::sweep {

/// Where the odometry's frame lies in a map that stays where it is: the way by wheels and floor
/// over that by wheels alone.
class MapAnchor {
 public:
  /// History begins anew, and with it the refined way, where the wheels are. A clock that was set
  /// back begins a new map. Where odometry jumped, the robot stays in its place in the map; where
  /// frames were missed, the odometry's frame does.
  void restart(Restart cause);
  /// T_map_odom at a frame, from its two poses.
  SE2 follow(const SE2& T_odom_wheels, const SE2& T_odom_refined);

 private:
  SE2 T_map_start_;  ///< the frame in which the refined way began
  SE2 T_map_odom_, T_map_base_;
  bool odometry_jumped_ = false;
};

}  // namespace ipm_mapping::sweep

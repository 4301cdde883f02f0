#include "ipm_mapping/sweep/map_anchor.hpp"

namespace ipm_mapping::sweep {

void MapAnchor::restart(Restart cause) {
  if (cause == Restart::Clock) *this = {};
  odometry_jumped_ = cause == Restart::Odometry || (odometry_jumped_ && cause == Restart::Missed);
  T_map_start_ = T_map_odom_;
}

SE2 MapAnchor::follow(const SE2& T_odom_wheels, const SE2& T_odom_refined) {
  if (odometry_jumped_) T_map_start_ = T_map_base_ * T_odom_refined.inverse();
  odometry_jumped_ = false;
  T_map_base_ = T_map_start_ * T_odom_refined;
  T_map_odom_ = T_map_base_ * T_odom_wheels.inverse();
  return T_map_odom_;
}

}  // namespace ipm_mapping::sweep

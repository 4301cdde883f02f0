#include "ipm_mapping/geometry/odometry_buffer.hpp"

#include <algorithm>
#include <cmath>

namespace ipm_mapping {
namespace {
// A message this much older than the newest is a clock that was set back (a bag that loops), not a
// late message.
constexpr double clock_jump_seconds = 1.0;
}  // namespace

const char* name(OdometryVerdict verdict) {
  switch (verdict) {
    case OdometryVerdict::Accepted:
      return "accepted";
    case OdometryVerdict::NotFinite:
      return "not_finite";
    case OdometryVerdict::Duplicate:
      return "duplicate";
    case OdometryVerdict::OutOfOrder:
      return "out_of_order";
    case OdometryVerdict::TimeJump:
      return "time_jump";
    case OdometryVerdict::PoseJump:
      return "pose_jump";
  }
  return "unknown";
}

OdometryVerdict OdometryBuffer::judge(double stamp, const SE2& T_odom_base) const {
  if (!std::isfinite(stamp) || !T_odom_base.finite()) return OdometryVerdict::NotFinite;
  if (poses_.empty()) return OdometryVerdict::Accepted;
  const StampedPose& last = poses_.back();
  const double dt = stamp - last.stamp;
  if (dt == 0.0) return OdometryVerdict::Duplicate;
  if (dt < -clock_jump_seconds) return OdometryVerdict::TimeJump;
  if (dt < 0.0) return OdometryVerdict::OutOfOrder;
  const SE2 step = last.T_odom_base.inverse() * T_odom_base;
  // Messages a few microseconds apart would make any noise look fast: half a frame is the floor.
  const double seconds = std::max(dt, 0.01);
  const bool jump = step.distance() > parameters_.max_speed * seconds ||
                    std::abs(step.theta) > parameters_.max_turn_rate * seconds;
  return jump ? OdometryVerdict::PoseJump : OdometryVerdict::Accepted;
}

OdometryVerdict OdometryBuffer::add(double stamp, const SE2& T_odom_base) {
  const OdometryVerdict verdict = judge(stamp, T_odom_base);
  if (startsAnew(verdict)) poses_.clear();
  if (startsAnew(verdict) || verdict == OdometryVerdict::Accepted) {
    poses_.push_back({stamp, T_odom_base});
    while (stamp - poses_.front().stamp > parameters_.buffer) poses_.pop_front();
  }
  return verdict;
}

PoseAnswer OdometryBuffer::at(double stamp, SE2& T_odom_base) const {
  if (poses_.empty() || stamp > poses_.back().stamp) return PoseAnswer::NotYet;
  if (stamp < poses_.front().stamp) return PoseAnswer::TooOld;
  const auto after =
      std::lower_bound(poses_.begin(), poses_.end(), stamp,
                       [](const StampedPose& pose, double t) { return pose.stamp < t; });
  if (after->stamp == stamp) {
    T_odom_base = after->T_odom_base;
    return PoseAnswer::Known;
  }
  const auto before = after - 1;
  const double gap = after->stamp - before->stamp;
  if (gap > parameters_.max_gap) return PoseAnswer::Gap;
  T_odom_base = interpolate(before->T_odom_base, after->T_odom_base, (stamp - before->stamp) / gap);
  return PoseAnswer::Known;
}

std::optional<double> OdometryBuffer::newest() const {
  if (poses_.empty()) return std::nullopt;
  return poses_.back().stamp;
}

}  // namespace ipm_mapping

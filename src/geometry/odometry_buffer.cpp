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
    case OdometryVerdict::Outlier:
      return "outlier";
    case OdometryVerdict::PoseJump:
      return "pose_jump";
  }
  return "unknown";
}

void OdometryBuffer::clear() {
  poses_.clear();
  suspect_.reset();
}

bool OdometryBuffer::jumps(const StampedPose& from, double stamp, const SE2& T_odom_base) const {
  const SE2 step = from.T_odom_base.inverse() * T_odom_base;
  // Messages that nearly coincide would make any noise look fast.
  const double seconds = std::max(stamp - from.stamp, 0.01);
  return step.distance() > parameters_.max_speed * seconds ||
         std::abs(step.theta) > parameters_.max_turn_rate * seconds;
}

bool OdometryBuffer::leavesTrack(double stamp, const SE2& T_odom_base) const {
  if (poses_.size() < 2) return false;
  const StampedPose& last = poses_.back();
  const StampedPose& before = poses_[poses_.size() - 2];
  const double seconds = stamp - last.stamp;
  const double share = seconds / std::max(last.stamp - before.stamp, 0.01);
  const SE2 was = before.T_odom_base.inverse() * last.T_odom_base;
  const SE2 expected{share * was.x, share * was.y, share * was.theta};
  const SE2 deviation = expected.inverse() * (last.T_odom_base.inverse() * T_odom_base);
  const double allowance = std::max(1.0, seconds / 0.1);
  return deviation.distance() > parameters_.max_jump * allowance ||
         std::abs(deviation.theta) > parameters_.max_turn_jump * allowance;
}

OdometryVerdict OdometryBuffer::judge(double stamp, const SE2& T_odom_base) const {
  if (!std::isfinite(stamp) || !T_odom_base.finite()) return OdometryVerdict::NotFinite;
  if (poses_.empty()) return OdometryVerdict::Accepted;
  const double seconds = stamp - poses_.back().stamp;
  if (seconds == 0.0) return OdometryVerdict::Duplicate;
  if (seconds < -clock_jump_seconds) return OdometryVerdict::TimeJump;
  if (seconds < 0.0) return OdometryVerdict::OutOfOrder;
  return jumps(poses_.back(), stamp, T_odom_base) || leavesTrack(stamp, T_odom_base)
             ? OdometryVerdict::Outlier
             : OdometryVerdict::Accepted;
}

/// One wild message is a glitch; two in a row that agree are a robot whose odometry was reset.
OdometryVerdict OdometryBuffer::confirmJump(double stamp, const SE2& T_odom_base) {
  const bool confirmed =
      suspect_ && stamp > suspect_->stamp && !jumps(*suspect_, stamp, T_odom_base);
  if (!confirmed) {
    suspect_ = StampedPose{stamp, T_odom_base};
    return OdometryVerdict::Outlier;
  }
  poses_.assign({*suspect_});
  return OdometryVerdict::PoseJump;
}

OdometryVerdict OdometryBuffer::add(double stamp, const SE2& T_odom_base) {
  OdometryVerdict verdict = judge(stamp, T_odom_base);
  if (verdict == OdometryVerdict::Outlier) verdict = confirmJump(stamp, T_odom_base);
  if (verdict == OdometryVerdict::TimeJump) poses_.clear();
  if (startsAnew(verdict) || verdict == OdometryVerdict::Accepted) {
    suspect_.reset();
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

Velocity OdometryBuffer::velocity(double stamp) const {
  constexpr double span = 0.05, least_window = 0.005;  // seconds
  auto after = std::lower_bound(poses_.begin(), poses_.end(), stamp,
                                [](const StampedPose& pose, double t) { return pose.stamp < t; });
  if (after == poses_.end() || poses_.size() < 2) return {};
  auto before = after == poses_.begin() ? after : after - 1;
  while (after->stamp - before->stamp < span) {
    const bool can_back = before != poses_.begin(), can_on = after + 1 != poses_.end();
    if (!can_back && !can_on) break;
    if (can_on && (!can_back || (after + 1)->stamp - stamp < stamp - (before - 1)->stamp))
      ++after;
    else
      --before;
  }
  const double seconds = after->stamp - before->stamp;
  if (seconds < least_window || seconds > parameters_.max_gap) return {};
  const Eigen::Vector3d v = logarithm(before->T_odom_base.inverse() * after->T_odom_base) / seconds;
  return {v.x(), v.y(), v.z()};
}

std::optional<double> OdometryBuffer::newest() const {
  if (poses_.empty()) return std::nullopt;
  return poses_.back().stamp;
}

}  // namespace ipm_mapping

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <deque>
#include <memory>

#include "ipm_mapping/geometry/odometry_buffer.hpp"

namespace ipm_mapping {

/// Why a frame left the gate without a pose.
enum class GateDrop : std::uint8_t {
  Overflow,     ///< too many frames waited for odometry
  NoOdometry,   ///< odometry stood still for `wait` and had not reached the stamp
  TooOld,       ///< odometry no longer reaches back to the stamp
  OdometryGap,  ///< odometry messages too far apart around the stamp
  OutOfOrder,   ///< stamp not newer than the frame before it
  BadStamp,     ///< not finite
  ClockJump     ///< it waited for odometry when the clock was set back
};
inline constexpr int gate_drop_count = 7;
[[nodiscard]] const char* name(GateDrop reason);

/// Holds frames until odometry has passed their stamps, then releases them in order with their
/// pose. The same class serves live topics and bags, so both see the same frames.
///
/// `arrival` is when a message came in, seconds of any clock that the caller keeps to: messages of
/// different topics may overtake one another, so stamps alone do not tell whether odometry is lost
/// or only behind. Left out, it is the stamp.
///
/// With a time offset frames leave with stamps that are moved by it, and with the pose and velocity
/// of then. A change comes into force bit by bit, so that frames keep their order.
///
/// `Payload` is what the caller keeps of a frame (a message pointer).
template <class Payload>
class FrameGate {
 public:
  struct Released {
    Payload payload;
    double stamp = 0.0;
    SE2 T_odom_base = {};
    Velocity velocity = {};
    double time_offset = 0.0;  ///< that the stamp was moved by
  };

  explicit FrameGate(const OdometryParameters& parameters = {}, std::size_t capacity = 32)
      : parameters_(parameters), capacity_(capacity), odometry_(parameters) {}

  /// Returns true when history in later stages has to be forgotten (clock or pose jumped).
  bool addOdometry(double stamp, const SE2& T_odom_base, OdometryVerdict* verdict = nullptr) {
    return addOdometry(stamp, T_odom_base, stamp, verdict);
  }
  bool addOdometry(double stamp, const SE2& T_odom_base, double arrival,
                   OdometryVerdict* verdict = nullptr) {
    const OdometryVerdict v = odometry_.add(stamp, T_odom_base);
    if (verdict) *verdict = v;
    if (v == OdometryVerdict::Accepted || startsAnew(v)) last_progress_ = arrival;
    if (v == OdometryVerdict::TimeJump) {
      dropWaiting(GateDrop::ClockJump);
      last_stamp_ = last_released_ = -1e300;
    }
    return startsAnew(v);
  }

  /// Returns true when the clock jumped back and history has to be forgotten.
  bool addFrame(double stamp, Payload payload) {
    return addFrame(stamp, std::move(payload), stamp);
  }
  bool addFrame(double stamp, Payload payload, double arrival) {
    if (!std::isfinite(stamp)) {
      count(GateDrop::BadStamp);
      return false;
    }
    bool jumped = false;
    if (stamp <= last_stamp_) {
      if (last_stamp_ - stamp < clock_jump_seconds) {
        count(GateDrop::OutOfOrder);
        return false;
      }
      // Odometry of before the jump must not serve frames of after it.
      if (odometry_.newest().value_or(stamp) - stamp > clock_jump_seconds) odometry_.clear();
      dropWaiting(GateDrop::ClockJump);
      last_progress_ = last_released_ = -1e300;
      jumped = true;
    }
    last_stamp_ = stamp;
    last_arrival_ = arrival;
    if (waiting_.size() == capacity_) {
      waiting_.pop_front();
      count(GateDrop::Overflow);
    }
    waiting_.push_back({{std::move(payload), stamp}, arrival});
    return jumped;
  }

  /// Takes the next frame whose pose is known into `released`; false when none is ready. `now`: of
  /// the same clock as the arrivals; without it, when the newest frame came.
  bool next(Released& released) { return next(released, last_arrival_); }
  bool next(Released& released, double now) {
    while (!waiting_.empty()) {
      SE2 T_odom_base;
      const double stamp = waiting_.front().frame.stamp, offset = timeOffsetAt(stamp);
      const PoseAnswer answer = odometry_.at(stamp + offset, T_odom_base);
      if (answer == PoseAnswer::NotYet && !overdue(now)) return false;
      released = std::move(waiting_.front().frame);
      waiting_.pop_front();
      last_released_ = stamp;
      offset_in_force_ = offset;
      released.stamp = stamp + offset;
      released.time_offset = offset;
      released.T_odom_base = T_odom_base;
      released.velocity = odometry_.velocity(released.stamp);
      if (answer == PoseAnswer::Known) return true;
      count(answer == PoseAnswer::NotYet   ? GateDrop::NoOdometry
            : answer == PoseAnswer::TooOld ? GateDrop::TooOld
                                           : GateDrop::OdometryGap);
    }
    return false;
  }

  /// Images were taken so many seconds after their stamps.
  void setTimeOffset(double seconds) { time_offset_ = seconds; }

  /// Frames that still wait when the input ends: they are dropped and counted.
  void finish() { dropWaiting(GateDrop::NoOdometry); }

  [[nodiscard]] std::uint64_t dropped(GateDrop reason) const {
    return drops_[static_cast<std::size_t>(reason)];
  }
  [[nodiscard]] std::size_t waiting() const { return waiting_.size(); }
  [[nodiscard]] const OdometryBuffer& odometry() const { return odometry_; }

 private:
  static constexpr double clock_jump_seconds = 1.0;
  static constexpr double most_of_interval = 0.25;  ///< that the offset changes by

  struct Waiting {
    Released frame;
    double arrival = 0.0;
  };

  /// Newer frames came, and odometry has brought nothing since long before `now`. While it makes
  /// progress, only the capacity bounds the wait.
  [[nodiscard]] bool overdue(double now) const {
    const Waiting& first = waiting_.front();
    return last_stamp_ - first.frame.stamp > parameters_.wait &&
           now - std::max(first.arrival, last_progress_) > parameters_.wait;
  }
  [[nodiscard]] double timeOffsetAt(double stamp) const {
    const double most = most_of_interval * std::max(0.0, stamp - last_released_);
    return std::clamp(time_offset_, offset_in_force_ - most, offset_in_force_ + most);
  }
  void dropWaiting(GateDrop reason) {
    for (; !waiting_.empty(); waiting_.pop_front()) count(reason);
  }
  void count(GateDrop reason) { ++drops_[static_cast<std::size_t>(reason)]; }

  OdometryParameters parameters_;
  std::size_t capacity_;
  OdometryBuffer odometry_;
  std::deque<Waiting> waiting_;
  double last_stamp_ = -1e300, last_arrival_ = -1e300, last_progress_ = -1e300;
  double last_released_ = -1e300, time_offset_ = 0.0, offset_in_force_ = 0.0;
  std::array<std::uint64_t, gate_drop_count> drops_{};
};

}  // namespace ipm_mapping

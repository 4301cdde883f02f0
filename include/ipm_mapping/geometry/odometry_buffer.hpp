#pragma once

#include <deque>
#include <optional>

#include "ipm_mapping/geometry/se2.hpp"
#include "ipm_mapping/parameters/map_parameters.hpp"

namespace ipm_mapping {

/// What became of one odometry message.
enum class OdometryVerdict {
  Accepted,
  NotFinite,   ///< NaN or infinite pose or stamp: dropped
  Duplicate,   ///< same stamp as the newest: dropped
  OutOfOrder,  ///< slightly older than the newest: dropped
  TimeJump,    ///< far older than the newest: the buffer was cleared and starts anew
  Outlier,     ///< a jump that nothing has confirmed yet: dropped
  PoseJump     ///< a jump that the next message confirmed: the buffer starts anew from both
};
[[nodiscard]] const char* name(OdometryVerdict verdict);
/// True when what was seen before the message must not be compared with what comes after it.
[[nodiscard]] inline bool startsAnew(OdometryVerdict verdict) {
  return verdict == OdometryVerdict::TimeJump || verdict == OdometryVerdict::PoseJump;
}

/// What the buffer can say about one instant.
enum class PoseAnswer { Known, NotYet, TooOld, Gap };

/// Robot poses over time; answers for image stamps by interpolation between the two neighbours.
class OdometryBuffer {
 public:
  explicit OdometryBuffer(const OdometryParameters& parameters = {}) : parameters_(parameters) {}

  OdometryVerdict add(double stamp, const SE2& T_odom_base);
  /// Pose at `stamp` into `T_odom_base` when the answer is Known.
  PoseAnswer at(double stamp, SE2& T_odom_base) const;
  /// Mean velocity over the messages around `stamp`, of which at() knows the pose; none where they
  /// are too far apart or too close together to tell.
  [[nodiscard]] Velocity velocity(double stamp) const;
  void clear();

  [[nodiscard]] bool empty() const { return poses_.empty(); }
  /// Stamp of the newest pose; nothing when empty.
  [[nodiscard]] std::optional<double> newest() const;

 private:
  struct StampedPose {
    double stamp;
    SE2 T_odom_base;
  };
  [[nodiscard]] OdometryVerdict judge(double stamp, const SE2& T_odom_base) const;
  [[nodiscard]] bool jumps(const StampedPose& from, double stamp, const SE2& T_odom_base) const;
  [[nodiscard]] bool leavesTrack(double stamp, const SE2& T_odom_base) const;
  OdometryVerdict confirmJump(double stamp, const SE2& T_odom_base);

  OdometryParameters parameters_;
  std::deque<StampedPose> poses_;
  std::optional<StampedPose> suspect_;  ///< the last outlier
};

}  // namespace ipm_mapping

#pragma once
// How the robot moves, and what its wheels say about it.

#include <vector>

#include "ipm_mapping/geometry/se2.hpp"
#include "ipm_mapping_sim/patch.hpp"
#include "ipm_mapping_sim/random.hpp"

namespace ipm_mapping::sim {

struct Command {
  double v = 0.0, w = 0.0;
};

/// What a script asks for `time` seconds after its start; rest before and after it.
Command scriptedCommand(const std::vector<DriveSegment>& drive, double time);
/// How the wheels hold at a time; full grip outside of the slips.
const SlipSpec& slipAt(const OdometrySpec& odometry, double time);

/// Distance from a point to an outline, where that is at a time; 0 inside a closed one.
double distanceTo(const Footprint& footprint, const Point& point, double time);

/// Pose after `distance` metres along an arc that turns by `turn`; the heading is not wrapped.
SE2 alongArc(const SE2& from, double distance, double turn);

/// The true motion: limited acceleration, slip, and a stop at whatever is too high to drive over.
class Body {
 public:
  Body(const RobotSpec& spec, std::vector<Footprint> footprints);

  /// One step of `dt` seconds from `time` on towards the commanded speeds; the grip is true per
  /// turned motion.
  void step(const Command& command, const SlipSpec& grip, double time, double dt);

  [[nodiscard]] const SE2& pose() const { return pose_; }
  [[nodiscard]] const Command& wheels() const { return wheels_; }
  [[nodiscard]] bool touching() const { return touching_; }

 private:
  [[nodiscard]] bool free(const SE2& pose, double time) const;

  RobotSpec spec_;
  std::vector<Footprint> footprints_;
  SE2 pose_;
  Command wheels_;
  bool touching_ = false;
};

/// One odometry message's content.
struct OdometryReading {
  double time = 0.0;
  SE2 pose;
  Command speed;
  bool arrives = true;
};

/// Integrates what imperfect wheels report.
class Odometer {
 public:
  Odometer(const OdometrySpec& spec, std::uint64_t seed)
      : spec_(spec), noise_(seed, Stream::Odometry), drops_(seed, Stream::Drop) {}

  /// The reading at `time`, after wheels that moved at `wheels` on average for `dt` seconds.
  OdometryReading read(double time, const Command& wheels, double dt);

 private:
  OdometrySpec spec_;
  RandomSequence noise_, drops_;
  SE2 pose_;
};

/// The scripted drive of a scene from kLead seconds before the first frame until its end.
class Drive {
 public:
  Drive(const Scene& scene, const std::vector<Footprint>& footprints);

  static constexpr double kLead = 0.2;

  [[nodiscard]] double duration() const { return duration_; }
  /// True pose at `time` seconds after the first frame; headings are not wrapped.
  [[nodiscard]] SE2 pose(double time) const;
  [[nodiscard]] Command wheels(double time) const;
  [[nodiscard]] const std::vector<OdometryReading>& odometry() const { return odometry_; }
  /// Time of the first contact with an obstacle; negative if there is none.
  [[nodiscard]] double collision() const { return collision_; }

 private:
  struct State {
    SE2 pose;
    Command wheels;
  };
  [[nodiscard]] std::pair<std::size_t, double> place(double time) const;

  double duration_, step_;
  double collision_ = -1.0;
  std::vector<State> states_;
  std::vector<OdometryReading> odometry_;
};

}  // namespace ipm_mapping::sim

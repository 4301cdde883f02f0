#pragma once
// The robot's motion in real time: commanded from outside, or by the scene's script until somebody
// commands it.

#include <deque>
#include <mutex>

#include "ipm_mapping_sim/motion.hpp"

namespace ipm_mapping::sim {

/// Safe to be stepped by one thread and asked by others.
class LiveMotion {
 public:
  LiveMotion(const Scene& scene, const std::vector<Footprint>& footprints);

  /// Seconds without a command after which a commanded robot stops.
  static constexpr double kCommandTimeout = 0.5;

  /// Takes over from the script.
  void command(const Command& command);
  /// Advances to `time` seconds and returns the wheels' reading there. Time starts at 0.
  OdometryReading advance(double time);

  /// True pose at a time within the last two seconds; the nearest known one outside of them.
  [[nodiscard]] SE2 pose(double time) const;
  [[nodiscard]] Command wheels(double time) const;
  [[nodiscard]] bool touching() const;

 private:
  struct State {
    double time;
    SE2 pose;
    Command wheels;
  };
  [[nodiscard]] Command wanted() const;
  [[nodiscard]] State at(double time) const;

  Scene scene_;
  Body body_;
  Odometer odometer_;
  mutable std::mutex mutex_;
  double time_ = 0.0, commanded_at_ = -1.0;
  Command command_;
  std::deque<State> history_;
};

}  // namespace ipm_mapping::sim

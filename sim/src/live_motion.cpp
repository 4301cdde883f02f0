#include "ipm_mapping_sim/live_motion.hpp"

#include <algorithm>
#include <cmath>

namespace ipm_mapping::sim {
namespace {

constexpr double kStep = 0.005;
constexpr double kHistory = 2.0;

}  // namespace

LiveMotion::LiveMotion(const Scene& scene, const std::vector<Footprint>& footprints)
    : scene_(scene),
      body_(scene.robot, footprints),
      odometer_(scene.odometry, static_cast<std::uint64_t>(scene.seed)) {
  history_.push_back({0.0, {}, {}});
}

void LiveMotion::command(const Command& command) {
  const std::lock_guard<std::mutex> lock(mutex_);
  command_ = command;
  commanded_at_ = time_;
}

Command LiveMotion::wanted() const {
  if (commanded_at_ < 0.0) return scriptedCommand(scene_.drive, time_);
  return time_ - commanded_at_ <= kCommandTimeout ? command_ : Command{};
}

OdometryReading LiveMotion::advance(double time) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const double span = std::max(time - time_, 1e-6);
  const int steps = std::max(1, static_cast<int>(std::ceil(span / kStep)));
  Command moved;
  for (int i = 0; i < steps; ++i) {
    body_.step(wanted(), slipAt(scene_.odometry, time_), time_, span / steps);
    time_ += span / steps;
    moved.v += body_.wheels().v / steps;
    moved.w += body_.wheels().w / steps;
    history_.push_back({time_, body_.pose(), body_.wheels()});
  }
  while (history_.front().time < time_ - kHistory) history_.pop_front();
  return odometer_.read(time_, moved, span);
}

LiveMotion::State LiveMotion::at(double time) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto after = std::lower_bound(history_.begin(), history_.end(), time,
                                      [](const State& s, double t) { return s.time < t; });
  if (after == history_.begin()) return history_.front();
  if (after == history_.end()) return history_.back();
  const State &a = *(after - 1), &b = *after;
  const double t = (time - a.time) / (b.time - a.time);
  const SE2 pose{a.pose.x + t * (b.pose.x - a.pose.x), a.pose.y + t * (b.pose.y - a.pose.y),
                 a.pose.theta + t * (b.pose.theta - a.pose.theta)};
  return {time, pose, b.wheels};
}

SE2 LiveMotion::pose(double time) const { return at(time).pose; }
Command LiveMotion::wheels(double time) const { return at(time).wheels; }

bool LiveMotion::touching() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return body_.touching();
}

}  // namespace ipm_mapping::sim

#include "ipm_mapping_sim/motion.hpp"

#include <algorithm>
#include <cmath>

namespace ipm_mapping::sim {
namespace {

constexpr double kDrivable = 0.03;  // lower things, cables and planks, are driven over
constexpr int kStepsPerReading = 4;

double segmentDistance(const Point& a, const Point& b, const Point& p) {
  const Point along = b - a;
  const double length = along.squaredNorm();
  const double t = length > 0.0 ? std::clamp((p - a).dot(along) / length, 0.0, 1.0) : 0.0;
  return (a + t * along - p).norm();
}

bool inside(const std::vector<Point>& polygon, const Point& p) {
  bool in = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Point &a = polygon[i], &b = polygon[j];
    if ((a.y() > p.y()) == (b.y() > p.y())) continue;
    if (p.x() < a.x() + (p.y() - a.y()) * (b.x() - a.x()) / (b.y() - a.y())) in = !in;
  }
  return in;
}

double towards(double from, double to, double limit) {
  return from + std::clamp(to - from, -limit, limit);
}

}  // namespace

const SlipSpec& slipAt(const OdometrySpec& odometry, double time) {
  static const SlipSpec full{0.0, 0.0, 1.0, 1.0};
  for (const SlipSpec& slip : odometry.slips) {
    if (time >= slip.at && time < slip.at + slip.seconds) return slip;
  }
  return full;
}

Command scriptedCommand(const std::vector<DriveSegment>& drive, double time) {
  if (time < 0.0) return {};
  for (const DriveSegment& segment : drive) {
    if (time < segment.seconds) return {segment.v, segment.w};
    time -= segment.seconds;
  }
  return {};
}

double distanceTo(const Footprint& footprint, const Point& at, double time) {
  const std::vector<Point>& p = footprint.points;
  const Point point = at - goneAlong(footprint.way, time);
  if (footprint.closed && inside(p, point)) return 0.0;
  double nearest = 1e9;
  for (std::size_t i = footprint.closed ? 0 : 1; i < p.size(); ++i) {
    nearest = std::min(nearest, segmentDistance(p[(i + p.size() - 1) % p.size()], p[i], point));
  }
  return nearest;
}

SE2 alongArc(const SE2& from, double distance, double turn) {
  const double half = 0.5 * turn;
  const double chord = std::abs(half) < 1e-6 ? distance : distance * std::sin(half) / half;
  return {from.x + chord * std::cos(from.theta + half),
          from.y + chord * std::sin(from.theta + half), from.theta + turn};
}

Body::Body(const RobotSpec& spec, std::vector<Footprint> footprints)
    : spec_(spec), footprints_(std::move(footprints)) {}

bool Body::free(const SE2& pose, double time) const {
  for (const Footprint& footprint : footprints_) {
    if (footprint.height < kDrivable) continue;
    if (distanceTo(footprint, pose.translation(), time) < spec_.radius) return false;
  }
  return true;
}

void Body::step(const Command& command, const SlipSpec& grip, double time, double dt) {
  wheels_.v = towards(wheels_.v, command.v, spec_.acceleration * dt);
  wheels_.w = towards(wheels_.w, command.w, spec_.turn_acceleration * dt);
  if (wheels_.v == 0.0 && wheels_.w == 0.0) return;
  const SE2 next = alongArc(pose_, grip.grip * wheels_.v * dt, grip.turn_grip * wheels_.w * dt);
  touching_ = !free(next, time + dt) && wheels_.v != 0.0;
  if (touching_) {
    wheels_ = {};
  } else {
    pose_ = next;
  }
}

OdometryReading Odometer::read(double time, const Command& wheels, double dt) {
  OdometryReading reading;
  reading.time = time;
  reading.speed.v = wheels.v * (1.0 + spec_.scale) + spec_.speed_noise * noise_.normal();
  reading.speed.w =
      wheels.w * (1.0 + spec_.yaw_scale) + spec_.yaw_bias + spec_.turn_noise * noise_.normal();
  pose_ = alongArc(pose_, reading.speed.v * dt, reading.speed.w * dt);
  reading.pose = pose_;
  reading.arrives = drops_.uniform() >= spec_.drop_rate;
  return reading;
}

Drive::Drive(const Scene& scene, const std::vector<Footprint>& footprints)
    : duration_(driveDuration(scene)), step_(1.0 / (scene.odometry.rate * kStepsPerReading)) {
  Body body(scene.robot, footprints);
  Odometer odometer(scene.odometry, static_cast<std::uint64_t>(scene.seed));
  const auto before = static_cast<int>(std::lround(kLead / step_));
  const auto after = static_cast<int>(std::lround((duration_ + kLead) / step_));
  Command moved;
  for (int i = -before; i <= after; ++i) {
    const double time = i * step_;
    states_.push_back({body.pose(), body.wheels()});
    if ((i + before) % kStepsPerReading == 0) {
      odometry_.push_back(odometer.read(time, moved, kStepsPerReading * step_));
      moved = {};
    }
    body.step(scriptedCommand(scene.drive, time), slipAt(scene.odometry, time), time, step_);
    moved.v += body.wheels().v / kStepsPerReading;
    moved.w += body.wheels().w / kStepsPerReading;
    if (body.touching() && collision_ < 0.0) collision_ = std::max(time, 0.0);
  }
}

std::pair<std::size_t, double> Drive::place(double time) const {
  const double steps = std::max(0.0, (time + kLead) / step_);
  const std::size_t i = std::min(static_cast<std::size_t>(steps), states_.size() - 2);
  return {i, std::min(steps - static_cast<double>(i), 1.0)};
}

SE2 Drive::pose(double time) const {
  const auto [i, t] = place(time);
  const SE2 &a = states_[i].pose, &b = states_[i + 1].pose;
  return {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.theta + t * (b.theta - a.theta)};
}

Command Drive::wheels(double time) const { return states_[place(time).first].wheels; }

}  // namespace ipm_mapping::sim

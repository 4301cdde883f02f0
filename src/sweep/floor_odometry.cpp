#include "ipm_mapping/sweep/floor_odometry.hpp"

#include <algorithm>
#include <cmath>

namespace ipm_mapping::sweep {
namespace {

constexpr double unknown_variance = 1e6;  // of a velocity before there is a second frame

/// Rotates x and y of (x, y, theta).
Eigen::Matrix3d turnedBy(double theta) {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  R.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(theta).toRotationMatrix();
  return R;
}

Eigen::Matrix3d squared(const Eigen::Vector3d& v) { return v * v.transpose(); }

/// Covariance of wheel odometry over a stretch, base axes at its end. A heading that goes wrong
/// evenly by e over the stretch carries the robot x e / 2 sideways.
Eigen::Matrix3d wheelNoise(const MotionRefinementParameters& p, double shift, double way,
                           double turn, double seconds, double lever) {
  const double forward = p.sd_forward * way + shift, sideways = p.sd_sideways * way + shift;
  const double heading = p.sd_turn * way + p.sd_turn_share * turn + p.sd_turn_rate * seconds;
  const Eigen::Vector3d by_heading(0.0, lever, 1.0);
  Eigen::Matrix3d noise = heading * heading * squared(by_heading);
  noise(0, 0) += forward * forward;
  noise(1, 1) += sideways * sideways;
  return noise;
}

}  // namespace

FloorOdometry::FloorOdometry(const SweepParameters& sweep,
                             const FloorOdometryParameters& parameters) {
  configure(sweep, parameters);
}

void FloorOdometry::configure(const SweepParameters& sweep,
                              const FloorOdometryParameters& parameters) {
  wheels_ = sweep.refinement;
  parameters_ = parameters;
  references_.assign(static_cast<std::size_t>(sweep.reference.history), {});
  next_ = used_ = 0;
}

void FloorOdometry::reset() {
  next_ = used_ = 0;
  started_ = false;
}

const FloorPose& FloorOdometry::add(const FloorObservation& now) {
  Place place = arrive(now);
  const bool refined = now.motion != nullptr && now.motion->refined;
  const Place* reference = refined ? referenceAt(now.motion->reference_stamp) : nullptr;
  if (reference != nullptr) {
    const Correction correction = correct(*reference, *now.motion, place);
    followFloor(*reference, correction, place);
    measureVelocity(place, &correction);
    anchor_ = place;
  } else {
    if (started_) followWheels(place);
    measureVelocity(place, nullptr);
    if (!started_) anchor_ = place;
  }
  started_ = true;
  last_ = place;
  remember(place, now.reference);
  publish(place);
  return pose_;
}

/// The frame with odometry's totals; without a frame before it, where odometry puts it.
FloorOdometry::Place FloorOdometry::arrive(const FloorObservation& now) const {
  Place place;
  static_cast<OdometryOfFrame&>(place) = {now.T_odom_base, now.velocity, now.time_offset};
  place.stamp = now.stamp;
  place.pose = now.T_odom_base;
  if (!started_) return place;
  const SE2 step = last_.T_odom_base.inverse() * now.T_odom_base;
  place.way = last_.way + step.distance();
  place.turn = last_.turn + std::abs(step.theta);
  place.going = last_.going + (hasChanged(step) ? now.stamp - last_.stamp : 0.0);
  return place;
}

const FloorOdometry::Place* FloorOdometry::referenceAt(double stamp) const {
  const auto end = references_.begin() + static_cast<std::ptrdiff_t>(used_);
  const auto found = std::find_if(references_.begin(), end,
                                  [stamp](const Place& place) { return place.stamp == stamp; });
  return found == end ? nullptr : &*found;
}

FloorOdometry::Correction FloorOdometry::correct(const Place& reference,
                                                 const RefinedMotion& motion, const Place& now) {
  const SE2 odometry = odometryBetween(reference, now);
  const Eigen::Matrix3d R = turnedBy(-odometry.theta);
  return {logarithm(odometry.inverse() * motion.motion), R * motion.covariance * R.transpose(),
          now.going - reference.going};
}

void FloorOdometry::followWheels(Place& now) const {
  const SE2 delta = anchor_.T_odom_base.inverse() * now.T_odom_base;
  extend(
      anchor_, delta,
      wheelNoise(wheels_, parameters_.sd_shift * (now.turn - anchor_.turn), now.way - anchor_.way,
                 now.turn - anchor_.turn, now.going - anchor_.going, 0.5 * delta.x),
      now);
}

void FloorOdometry::followFloor(const Place& reference, const Correction& correction,
                                Place& now) const {
  const bool corrected_before = anchor_.stamp > reference.stamp;
  const Place& from = corrected_before ? anchor_ : reference;
  const double window = now.way - reference.way;
  const double share = corrected_before && window > 0.0 ? (now.way - from.way) / window : 1.0;
  const SE2 delta =
      from.T_odom_base.inverse() * now.T_odom_base * exponential(share * correction.error);
  extend(from, delta, share * correction.covariance, now);
}

/// now = from delta, `noise` that of delta in the axes of now. With T the way from `from` to now in
/// odom, a heading error at `from` moves now by (-T_y, T_x).
void FloorOdometry::extend(const Place& from, const SE2& delta, const Eigen::Matrix3d& noise,
                           Place& now) {
  now.pose = from.pose * delta;
  const Eigen::Vector2d T = now.pose.translation() - from.pose.translation();
  Eigen::Matrix3d J = Eigen::Matrix3d::Identity();
  J.topRightCorner<2, 1>() << -T.y(), T.x();
  const Eigen::Matrix3d R = turnedBy(now.pose.theta);
  now.covariance = J * from.covariance * J.transpose() + R * noise * R.transpose();
  now.by_scale = J * from.by_scale + Eigen::Vector3d(T.x(), T.y(), 0.0);
  now.by_turn = J * from.by_turn + T.norm() * Eigen::Vector3d(-0.5 * T.y(), 0.5 * T.x(), 1.0);
}

void FloorOdometry::remember(const Place& now, Kept kept) {
  if (kept == Kept::No) return;
  if (kept == Kept::InPlaceOfNewest && used_ > 0) {
    references_[(next_ + references_.size() - 1) % references_.size()] = now;
    return;
  }
  references_[next_] = now;
  next_ = (next_ + 1) % references_.size();
  used_ = std::min(used_ + 1, references_.size());
}

void FloorOdometry::publish(const Place& now) {
  pose_.T_odom_base = now.pose;
  pose_.covariance = now.covariance + squared(parameters_.sd_scale * now.by_scale) +
                     squared(parameters_.sd_turn * now.by_turn);
}

/// Odometry's velocity over the last frame, less what the floor says odometry got wrong on average
/// over the window: as prompt as the one, as true as the other.
void FloorOdometry::measureVelocity(const Place& now, const Correction* correction) {
  const double seconds = now.stamp - last_.stamp;
  if (!started_ || !(seconds > 0.0)) {
    pose_.velocity.setZero();
    pose_.velocity_covariance = unknown_variance * Eigen::Matrix3d::Identity();
    return;
  }
  pose_.velocity = logarithm(last_.T_odom_base.inverse() * now.T_odom_base) / seconds;
  const Eigen::Vector3d v = pose_.velocity;
  if (correction != nullptr && correction->seconds > 0.0) {
    pose_.velocity += correction->error / correction->seconds;
    pose_.velocity_covariance =
        correction->covariance / (correction->seconds * correction->seconds);
  } else {
    const double going = now.going > last_.going ? 1.0 : 0.0;
    pose_.velocity_covariance = wheelNoise(wheels_, parameters_.sd_shift * std::abs(v[2]),
                                           v.head<2>().norm(), std::abs(v[2]), going, 0.0);
  }
  pose_.velocity_covariance +=
      squared(parameters_.sd_scale * Eigen::Vector3d(v[0], v[1], 0.0)) +
      squared(Eigen::Vector3d(0.0, 0.0, parameters_.sd_turn * v.head<2>().norm()));
}

}  // namespace ipm_mapping::sweep

#include "ipm_mapping/mapping/localized_map.hpp"

#include <cmath>

namespace ipm_mapping {
namespace {

// Localisers that repeat themselves differ by less, in the last digits of a quaternion.
constexpr double least_metres = 0.005, least_radians = 0.002;
// No correction of drift brings the robot back by this much, metres.
constexpr double clear_jump = 0.5;

bool isCorrection(const SE2& D, const SE2& T_map_base) {
  const double moved = (D * T_map_base.translation() - T_map_base.translation()).norm();
  return moved > least_metres || std::abs(D.theta) > least_radians;
}

void copyEvidence(const Obstacles& from, Obstacles& to) {
  to.view = from.view;
  to.bearings = from.bearings;
  to.contacts = from.contacts;
}

}  // namespace

LocalizedMap::LocalizedMap(OccupancyMap& map, MapCorrection correction, int frames)
    : map_(map),
      base_(map),
      correction_(correction),
      ring_(correction == MapCorrection::Keep ? 0 : static_cast<std::size_t>(frames)) {}

bool LocalizedMap::update(const Obstacles& answer, const SE2& T_map_odom) {
  const SE2& T_odom_base = answer.view.T_odom_base;
  const SE2 D = T_map_odom_ ? T_map_odom * T_map_odom_->inverse() : SE2{};
  const bool corrected = isCorrection(D, T_map_odom_.value_or(T_map_odom) * T_odom_base);
  if (corrected && odometryBeganAnew(T_odom_base, T_map_odom)) forget();
  if (T_odom_base_) way_ += (T_odom_base_->inverse() * T_odom_base).distance();
  if (corrected) replace(D);
  T_map_odom_ = T_map_odom;
  T_odom_base_ = T_odom_base;
  copyEvidence(answer, placed_);
  placed_.view.T_odom_base = T_map_odom * T_odom_base;
  remember();
  map_.update(placed_);
  return corrected;
}

/// The robot would have jumped without the correction, and with it does not.
bool LocalizedMap::odometryBeganAnew(const SE2& T_odom_base, const SE2& T_map_odom) const {
  if (!T_odom_base_) return false;
  const Eigen::Vector2d before = (*T_map_odom_ * *T_odom_base_).translation();
  const double with = (T_map_odom * T_odom_base.translation() - before).norm();
  const double without = (*T_map_odom_ * T_odom_base.translation() - before).norm();
  return with + clear_jump < without;
}

void LocalizedMap::forget() {
  base_.restore(map_);
  first_ = size_ = 0;
  way_ = 0.0;
  T_odom_base_.reset();
}

void LocalizedMap::clear() {
  map_.clear();
  forget();
}

void LocalizedMap::remember() {
  if (ring_.empty()) return;
  if (size_ == ring_.size()) {
    base_.update(ring_[first_].answer);
    first_ = (first_ + 1) % ring_.size();
    --size_;
  }
  Remembered& slot = ring_[(first_ + size_++) % ring_.size()];
  copyEvidence(placed_, slot.answer);
  slot.way = way_;
}

void LocalizedMap::replace(const SE2& D) {
  if (ring_.empty()) return;
  map_.restore(base_);
  for (std::size_t i = 0; i < size_; ++i) {
    Remembered& frame = ring_[(first_ + i) % ring_.size()];
    const double share =
        correction_ == MapCorrection::Follow || way_ <= 0.0 ? 1.0 : frame.way / way_;
    SE2& T_map_base = frame.answer.view.T_odom_base;
    T_map_base = interpolate(T_map_base, D * T_map_base, share);
    map_.update(frame.answer);
  }
  forget();
}

}  // namespace ipm_mapping

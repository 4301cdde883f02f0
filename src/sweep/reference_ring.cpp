#include "ipm_mapping/sweep/reference_ring.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ipm_mapping::sweep {
namespace {

constexpr double turn_spacing = 0.02;  // radians: a turned view is worth keeping without travel

double distanceBetween(const SE2& a, const SE2& b) { return std::hypot(a.x - b.x, a.y - b.y); }
double turnBetween(const SE2& a, const SE2& b) { return std::abs(wrapAngle(a.theta - b.theta)); }

}  // namespace

void ReferenceRing::configure(const PolarGrid& grid, const SweepReferenceParameters& parameters) {
  parameters_ = parameters;
  spacing_ = parameters.spacing * grid.height;
  frames_.resize(static_cast<std::size_t>(parameters.history));
  for (RectifiedFrame& frame : frames_) frame.image.resize(grid.rows, grid.lines);
  next_ = used_ = 0;
}

std::size_t ReferenceRing::slot(int back) const {
  const int size = static_cast<int>(frames_.size());
  return static_cast<std::size_t>((next_ - 1 - back + 2 * size) % size);
}

Kept ReferenceRing::offer(RectifiedFrame& frame) {
  const auto beside = [this](const SE2& a, const SE2& b) {
    return distanceBetween(a, b) < spacing_;
  };
  if (used_ > 0 && beside(newest(0).T_odom_base, frame.T_odom_base)) {
    if (turnBetween(newest(0).T_odom_base, frame.T_odom_base) < turn_spacing) return Kept::No;
    if (used_ > 1 && beside(newest(1).T_odom_base, newest(0).T_odom_base)) {
      std::swap(frames_[slot(0)], frame);
      return Kept::InPlaceOfNewest;
    }
  }
  const int size = static_cast<int>(frames_.size());
  std::swap(frames_[static_cast<std::size_t>(next_)], frame);
  next_ = (next_ + 1) % size;
  used_ = std::min(used_ + 1, size);
  return Kept::Added;
}

const RectifiedFrame* ReferenceRing::firstBeyond(const RectifiedFrame& current,
                                                 double baseline) const {
  for (int back = 0; back < used_; ++back) {
    const RectifiedFrame& frame = newest(back);
    if (frame.age(current) > parameters_.max_age) return nullptr;
    if (distanceBetween(current.T_odom_base, frame.T_odom_base) >= baseline) return &frame;
  }
  return nullptr;
}

const RectifiedFrame* ReferenceRing::find(const RectifiedFrame& current, double baseline) const {
  const RectifiedFrame* frame = firstBeyond(current, baseline);
  if (frame == nullptr) return nullptr;
  const double turn = turnBetween(current.T_odom_base, frame->T_odom_base);
  return turn < parameters_.max_rotation ? frame : nullptr;
}

bool ReferenceRing::farEnough(const RectifiedFrame& current, double baseline) const {
  return firstBeyond(current, baseline) != nullptr;
}

}  // namespace ipm_mapping::sweep

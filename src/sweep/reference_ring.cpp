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

const RectifiedFrame& ReferenceRing::newest(int back) const {
  const int size = static_cast<int>(frames_.size());
  return frames_[static_cast<std::size_t>((next_ - 1 - back + 2 * size) % size)];
}

bool ReferenceRing::offer(RectifiedFrame& frame) {
  if (used_ > 0) {
    const SE2& last = newest(0).T_odom_base;
    if (distanceBetween(last, frame.T_odom_base) < spacing_ &&
        turnBetween(last, frame.T_odom_base) < turn_spacing)
      return false;
  }
  const int size = static_cast<int>(frames_.size());
  std::swap(frames_[static_cast<std::size_t>(next_)], frame);
  next_ = (next_ + 1) % size;
  used_ = std::min(used_ + 1, size);
  return true;
}

const RectifiedFrame* ReferenceRing::firstBeyond(const SE2& pose, double stamp,
                                                 double baseline) const {
  for (int back = 0; back < used_; ++back) {
    const RectifiedFrame& frame = newest(back);
    if (stamp - frame.stamp > parameters_.max_age) return nullptr;
    if (distanceBetween(pose, frame.T_odom_base) >= baseline) return &frame;
  }
  return nullptr;
}

const RectifiedFrame* ReferenceRing::find(const SE2& T_odom_base, double stamp,
                                          double baseline) const {
  const RectifiedFrame* frame = firstBeyond(T_odom_base, stamp, baseline);
  if (frame == nullptr) return nullptr;
  return turnBetween(T_odom_base, frame->T_odom_base) < parameters_.max_rotation ? frame : nullptr;
}

bool ReferenceRing::farEnough(const SE2& T_odom_base, double stamp, double baseline) const {
  return firstBeyond(T_odom_base, stamp, baseline) != nullptr;
}

}  // namespace ipm_mapping::sweep

#include "ipm_mapping/geometry/reference_selector.hpp"

#include <algorithm>
#include <cmath>

namespace ipm_mapping {

ReferenceSelector::ReferenceSelector(const ReferenceParameters& parameters)
    : parameters_(parameters),  // One slot more than frames to choose from: the next frame never
                                // lands on a chosen one.
      ring_(static_cast<std::size_t>(std::max(parameters.history, 1)) + 1) {}

const StoredFrame& ReferenceSelector::newest(int i) const {
  const int size = static_cast<int>(ring_.size());
  return ring_[static_cast<std::size_t>((head_ - 1 - i + 2 * size) % size)];
}

ReferenceSelector::Choice ReferenceSelector::choosePrevious(double stamp,
                                                            const SE2& T_odom_base) const {
  const StoredFrame& previous = newest(0);
  const SE2 motion = previous.T_odom_base.inverse() * T_odom_base;
  if (stamp - previous.stamp > parameters_.max_age) return {};
  if (motion.distance() < parameters_.min_motion)
    return {std::abs(motion.theta) > 1e-3 ? ReferenceVerdict::TooMuchRotation
                                          : ReferenceVerdict::NoMotion,
            nullptr, motion};
  return {ReferenceVerdict::Chosen, &previous, motion};
}

ReferenceSelector::Choice ReferenceSelector::choose(double stamp, const SE2& T_odom_base) const {
  if (count_ == 0) return {};
  if (parameters_.previous_frame) return choosePrevious(stamp, T_odom_base);

  Choice answer;
  for (int i = 0; i < count_; ++i) {
    const StoredFrame& candidate = newest(i);
    if (stamp - candidate.stamp > parameters_.max_age) break;
    const SE2 motion = candidate.T_odom_base.inverse() * T_odom_base;
    if (i == 0 && motion.distance() < parameters_.min_motion) {
      return {std::abs(motion.theta) > 1e-3 ? ReferenceVerdict::TooMuchRotation
                                            : ReferenceVerdict::NoMotion,
              nullptr, motion};
    }
    if (motion.distance() < parameters_.min_baseline) continue;
    if (std::abs(motion.theta) <= parameters_.max_rotation)
      return {ReferenceVerdict::Chosen, &candidate, motion};
    answer.verdict = ReferenceVerdict::TooMuchRotation;
    break;
  }
  return answer;
}

void ReferenceSelector::remember(double stamp, const SE2& T_odom_base, GrayView image) {
  if (count_ > 0 && !parameters_.previous_frame) {
    const SE2 step = newest(0).T_odom_base.inverse() * T_odom_base;
    if (step.distance() < parameters_.min_motion && std::abs(step.theta) < 1e-3) return;
  }
  StoredFrame& slot = ring_[static_cast<std::size_t>(head_)];
  slot.stamp = stamp;
  slot.T_odom_base = T_odom_base;
  slot.image.ensure(image.width, image.height);
  for (int v = 0; v < image.height; ++v) std::copy_n(image.row(v), image.width, slot.image.row(v));
  head_ = (head_ + 1) % static_cast<int>(ring_.size());
  count_ = std::min(count_ + 1, static_cast<int>(ring_.size()) - 1);
}

void ReferenceSelector::clear() {
  head_ = 0;
  count_ = 0;
}

}  // namespace ipm_mapping

#pragma once

#include <algorithm>

namespace ipm_mapping {

/// Time during which a message could have come: follows another clock, but a pause between two
/// looks at it counts as no more than `longest_step`. While the process gets no CPU time, or one
/// frame takes long, messages queue up unread, and nobody may call them late for that.
class WaitingClock {
 public:
  static constexpr double longest_step = 0.25;  ///< seconds

  /// `clock`: seconds of a clock that never goes back.
  double look(double clock) {
    if (started_) time_ += std::clamp(clock - last_, 0.0, longest_step);
    started_ = true;
    last_ = clock;
    return time_;
  }

 private:
  bool started_ = false;
  double last_ = 0.0, time_ = 0.0;
};

}  // namespace ipm_mapping

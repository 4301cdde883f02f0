#pragma once

#include <chrono>
#include <vector>

#include "ipm_mapping/detector.hpp"

namespace ipm_mapping {

/// Splits the time of one frame among its stages; `times` keeps its capacity from frame to frame.
class Stopwatch {
 public:
  explicit Stopwatch(std::vector<StageTime>& times) : times_(times), last_(Clock::now()) {
    times_.clear();
  }
  /// Time since the last call (or construction) belongs to `stage` (a literal).
  void lap(const char* stage) {
    const auto now = Clock::now();
    times_.push_back({stage, std::chrono::duration<double>(now - last_).count()});
    last_ = now;
  }

 private:
  using Clock = std::chrono::steady_clock;
  std::vector<StageTime>& times_;
  Clock::time_point last_;
};

}  // namespace ipm_mapping

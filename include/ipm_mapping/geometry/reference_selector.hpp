#pragma once

#include <cstdint>
#include <vector>

#include "ipm_mapping/geometry/se2.hpp"
#include "ipm_mapping/image_view.hpp"
#include "ipm_mapping/parameters/chain_parameters.hpp"

namespace ipm_mapping {

/// A raw frame that is kept as a possible reference.
struct StoredFrame {
  double stamp = 0.0;
  SE2 T_odom_base;
  Image<std::uint8_t> image;
};

/// Why no reference was chosen, or that one was.
enum class ReferenceVerdict { Chosen, NoMotion, NoReference, TooMuchRotation };

/// Ring of earlier frames; picks the one to compare with: the newest at least `min_baseline` back
/// that is neither too old nor turned too far (the source, §3.3, always takes the previous frame).
/// Pictures keep their memory when the ring wraps. A chosen frame stays as it is through the next
/// remember().
class ReferenceSelector {
 public:
  explicit ReferenceSelector(const ReferenceParameters& parameters = {});

  struct Choice {
    ReferenceVerdict verdict = ReferenceVerdict::NoReference;
    const StoredFrame* reference = nullptr;
    SE2 motion;  ///< M: pose of the current base in the reference base
  };
  [[nodiscard]] Choice choose(double stamp, const SE2& T_odom_base) const;

  /// Keeps a copy of the frame; a frame that moved less than `min_motion` since the newest one
  /// replaces nothing and is not kept, unless the previous frame is the reference anyway.
  void remember(double stamp, const SE2& T_odom_base, GrayView image);
  void clear();
  [[nodiscard]] int size() const { return count_; }

 private:
  /// i-th newest, 0 is the newest.
  [[nodiscard]] const StoredFrame& newest(int i) const;
  [[nodiscard]] Choice choosePrevious(double stamp, const SE2& T_odom_base) const;

  ReferenceParameters parameters_;
  std::vector<StoredFrame> ring_;
  int head_ = 0;  ///< where the next frame goes
  int count_ = 0;
};

}  // namespace ipm_mapping

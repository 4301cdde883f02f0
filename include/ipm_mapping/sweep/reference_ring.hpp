#pragma once

#include <cstdint>
#include <vector>

#include "ipm_mapping/sweep/motion_refinement.hpp"

namespace ipm_mapping::sweep {

/// What becomes of a frame that is offered as a reference of later ones.
enum class Kept : std::uint8_t { No, Added, InPlaceOfNewest };

/// Rectified frames of the recent past, at most one every `spacing`. Memory is reused.
class ReferenceRing {
 public:
  void configure(const PolarGrid& grid, const SweepReferenceParameters& parameters);
  void clear() { used_ = 0; }

  /// Keeps a frame if it lies far enough from the one kept before, or is turned away from it;
  /// `frame` then holds an older frame's memory. Of a robot that turns on the spot the first view
  /// and the latest are kept: to look around is no reason to lose where it came from.
  Kept offer(RectifiedFrame& frame);

  /// Newest frame at least `baseline` metres from another one, young enough and not turned away too
  /// far; null if there is none. The first frame that is far enough decides: an older one would be
  /// turned further.
  [[nodiscard]] const RectifiedFrame* find(const RectifiedFrame& current, double baseline) const;
  /// Does something to all frames, and to the memory that waits for others.
  template <class Change>
  void forEach(const Change& change) {
    for (RectifiedFrame& frame : frames_) change(frame);
  }
  /// Any frame at least `baseline` away and young enough, however turned: tells why find() failed.
  [[nodiscard]] bool farEnough(const RectifiedFrame& current, double baseline) const;
  [[nodiscard]] int size() const { return used_; }

 private:
  [[nodiscard]] std::size_t slot(int back) const;
  [[nodiscard]] const RectifiedFrame& newest(int back) const { return frames_[slot(back)]; }
  [[nodiscard]] const RectifiedFrame* firstBeyond(const RectifiedFrame& current,
                                                  double baseline) const;

  SweepReferenceParameters parameters_;
  double spacing_ = 0.0;
  std::vector<RectifiedFrame> frames_;
  int next_ = 0, used_ = 0;
};

}  // namespace ipm_mapping::sweep

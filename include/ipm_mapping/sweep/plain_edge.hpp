#pragma once

#include <cstdint>
#include <vector>

#include "ipm_mapping/parameters/sweep_parameters.hpp"
#include "ipm_mapping/sweep/vertical_sweep.hpp"

namespace ipm_mapping::sweep {

/// Behind an edge of the image there is more floor, or something plain that stands there, which
/// looks like floor. The floor's texture tells them apart: behind a line that is only painted on
/// it, a joint or the border of a shadow it goes on, and an upright surface does not explain it,
///   sum over rows of foot_support of w (F - V - prior) < -foot_doubt.
class PlainEdge {
 public:
  static constexpr int edge_rows = 2;  ///< rows on either side of an edge that it blurs

  void configure(const VerticalSweep& sweep, const FreeFloorParameters& free_floor,
                 const FootParameters& parameters);

  /// May something stand at a candidate that is an edge of the image? No where the floor's texture
  /// goes on behind it, or too little can be compared. Needs VerticalSweep::aimBeam().
  bool mayStand(const SweepReference* references, int count, VerticalSweep& sweep, int beam,
                int candidate) const;

  /// Nearest edge of a beam, nearer than `range`, behind which something may stand; -1: none.
  int nearest(const CurrentView& current, const SweepReference* references, int count,
              VerticalSweep& sweep, int beam, double range);

  /// Distance, in metres from the camera's foot, of the nearest edge of a beam behind which
  /// something may stand; `range` where there is none in front of it.
  double limit(const CurrentView& current, const SweepReference* references, int count,
               VerticalSweep& sweep, int beam, double range);

 private:
  void fillProfile(const CurrentView& current, int first_line);

  int support_rows_ = 0;
  float doubt_ = 0.0F;
  std::int32_t least_step_ = 0;        // of the profile from row - 1 to row + 1
  std::vector<std::int32_t> profile_;  // sum over a beam's lines of every sweep row
};

}  // namespace ipm_mapping::sweep

#pragma once
// Software part of rule 10: the 28-bit focus word (§6.8, eq. 6.8 and 6.9).

#include "ipm_mapping/fpga/polar_histogram.hpp"
#include "ipm_mapping/geometry/vanishing_point.hpp"

namespace ipm_mapping::fpga {

struct QuantisedFocus {
  FocusWord word;
  bool usable = false;   ///< false: the frame is skipped as focus_unusable
  bool clamped = false;  ///< focus_clamped: the beam keeps its direction in the image centre only
};

/// Rounds the focus into its word; a focus that does not fit, or lies at infinity, moves towards
/// the image centre c = ((W-1)/2, (H-1)/2) along the direction that the beam has there.
[[nodiscard]] QuantisedFocus quantiseFocus(const Focus& focus, int width, int height);

}  // namespace ipm_mapping::fpga

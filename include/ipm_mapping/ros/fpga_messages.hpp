#pragma once

#include <ipm_mapping/FpgaReport.h>

#include "ipm_mapping/detectors/fpga_detector.hpp"

namespace ipm_mapping {

/// A tagged wire as two pictures of its size: grey levels, 0 where there is no correspondence, and
/// 255 where there is one.
void splitTagged(ImageView<const fpga::TaggedPixel> wire, GrayBuffer grey, GrayBuffer valid);

/// Registers, results and cycles of the detector's last used frame; everything but the header.
void toMessage(const FpgaDetector& detector, const FpgaClockParameters& clock, FpgaReport& message);

}  // namespace ipm_mapping

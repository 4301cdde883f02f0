#pragma once
// Twin of the subtraction (the source, §6.4; rules 5-7).

#include "ipm_mapping/fpga/frame_parameters.hpp"
#include "ipm_mapping/fpga/overflow.hpp"

namespace ipm_mapping::fpga {

/// Rule 7: |reference - current| of two 8-bit pixels.
TaggedPixel absoluteDifference(std::uint8_t reference, std::uint8_t current);

/// Writes the whole difference image: 0x100 where either stream has no correspondence.
void difference(const FrameInputs& inputs, ImageView<TaggedPixel> out, OverflowCounters& counters);

}  // namespace ipm_mapping::fpga

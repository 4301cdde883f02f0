#pragma once
// Twin of the 3x3 erosion (the source, §6.7; rule 8).

#include <cstdint>

#include "ipm_mapping/image_view.hpp"

namespace ipm_mapping::fpga {

/// 1 where all nine mask pixels are 1; border pixels are 0.
void erosion(ImageView<const std::uint8_t> mask, ImageView<std::uint8_t> out);

}  // namespace ipm_mapping::fpga

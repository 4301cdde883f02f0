#pragma once
// Twin of the 3x3 Gaussian filter (the source, §6.5, eq. 6.7; rule 8).

#include "ipm_mapping/fpga/formats.hpp"
#include "ipm_mapping/image_view.hpp"

namespace ipm_mapping::fpga {

/// Every term is shifted before the sum. Border pixels and pixels whose centre has no
/// correspondence are 0x100; a neighbour without one counts 0.
void gaussian(ImageView<const TaggedPixel> in, ImageView<TaggedPixel> out);

}  // namespace ipm_mapping::fpga

#pragma once
// Body of the sway's correction. Single precision, every operation correctly rounded: every SIMD
// target gives the same bytes.

#include <cstdint>

#include "ipm_mapping/image_view.hpp"

namespace ipm_mapping::kernels {

/// Where the rows of a line are found in an image of another attitude:
/// row + along * stretch[row], line + across * r[row]. The arrays hold `overrun` elements more.
struct SwayShift {
  const float* stretch = nullptr;
  const float* r = nullptr;
  float along = 0.0F, across = 0.0F;
};

/// out[row] = image there, bilinear, for rows begin ... end - 1 (at least two), and anything for up
/// to `overrun` rows after them. Positions stop at those rows and at the first and last line.
void swayLine(ImageView<const std::uint8_t> image, int line, const SwayShift& shift, int begin,
              int end, std::uint8_t* out);

}  // namespace ipm_mapping::kernels

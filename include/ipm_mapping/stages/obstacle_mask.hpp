#pragma once

#include <cstdint>

#include "ipm_mapping/image_view.hpp"
#include "ipm_mapping/kernels/chain_segment.hpp"

/// Values of an obstacle mask.
namespace ipm_mapping::mask {

inline constexpr std::uint8_t floor = 0;
inline constexpr std::uint8_t unseen = 128;
inline constexpr std::uint8_t obstacle = 255;

/// eroded and valid (255 or 0 each) to mask values.
inline void compose(GrayView eroded, GrayView valid, GrayBuffer out) {
  for (int v = 0; v < eroded.height; ++v)
    kernels::composeMaskRow(eroded.row(v), valid.row(v), eroded.width, out.row(v));
}

}  // namespace ipm_mapping::mask

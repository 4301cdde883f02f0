#pragma once

#include <cstdint>

#include "ipm_mapping/image_view.hpp"

/// Values of an obstacle mask.
namespace ipm_mapping::mask {

inline constexpr std::uint8_t floor = 0;
inline constexpr std::uint8_t unseen = 128;
inline constexpr std::uint8_t obstacle = 255;

/// eroded (255 or 0) and valid (not 0 or 0) to mask values.
inline void compose(GrayView eroded, GrayView valid, GrayBuffer out) {
  for (int v = 0; v < eroded.height; ++v) {
    const std::uint8_t* e = eroded.row(v);
    const std::uint8_t* s = valid.row(v);
    std::uint8_t* o = out.row(v);
    for (int u = 0; u < eroded.width; ++u)
      o[u] = static_cast<std::uint8_t>(e[u] ? obstacle : (s[u] ? floor : unseen));
  }
}

}  // namespace ipm_mapping::mask

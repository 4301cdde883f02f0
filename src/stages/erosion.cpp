#include "ipm_mapping/stages/erosion.hpp"

#include <algorithm>

namespace ipm_mapping {

void erode(GrayView binary, GrayBuffer eroded) {
  const int W = binary.width, H = binary.height;
  for (int v = 0; v < H; ++v) {
    std::uint8_t* out = eroded.row(v);
    if (v == 0 || v == H - 1 || W < 3) {
      std::fill_n(out, W, std::uint8_t{0});
      continue;
    }
    const std::uint8_t* a = binary.row(v - 1);
    const std::uint8_t* b = binary.row(v);
    const std::uint8_t* c = binary.row(v + 1);
    for (int u = 1; u < W - 1; ++u) {
      out[u] = static_cast<std::uint8_t>(a[u - 1] & a[u] & a[u + 1] & b[u - 1] & b[u] & b[u + 1] &
                                         c[u - 1] & c[u] & c[u + 1]);
    }
    out[0] = out[W - 1] = 0;
  }
}

}  // namespace ipm_mapping

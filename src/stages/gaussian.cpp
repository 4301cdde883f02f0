#include "ipm_mapping/stages/gaussian.hpp"

#include <algorithm>

namespace ipm_mapping {

void Gaussian::operator()(GrayView image, GrayView valid, GrayBuffer blurred,
                          GrayBuffer blurred_valid) {
  const int W = image.width, H = image.height;
  column_sums_.resize(static_cast<std::size_t>(W));
  std::uint16_t* sum = column_sums_.data();
  for (int v = 0; v < H; ++v) {
    std::uint8_t* out = blurred.row(v);
    std::uint8_t* seen = blurred_valid.row(v);
    if (v == 0 || v == H - 1 || W < 3) {
      std::fill_n(out, W, std::uint8_t{0});
      std::fill_n(seen, W, std::uint8_t{0});
      continue;
    }
    const std::uint8_t* above = image.row(v - 1);
    const std::uint8_t* here = image.row(v);
    const std::uint8_t* below = image.row(v + 1);
    const std::uint8_t* centre = valid.row(v);
    for (int u = 0; u < W; ++u)
      sum[u] = static_cast<std::uint16_t>(above[u] + 2 * here[u] + below[u]);
    for (int u = 1; u < W - 1; ++u) {
      const int total = (sum[u - 1] + 2 * sum[u] + sum[u + 1] + 8) >> 4;
      out[u] = static_cast<std::uint8_t>(centre[u] ? total : 0);
      seen[u] = centre[u];
    }
    out[0] = out[W - 1] = seen[0] = seen[W - 1] = 0;
  }
}

}  // namespace ipm_mapping

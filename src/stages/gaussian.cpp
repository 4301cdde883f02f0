#include "ipm_mapping/stages/gaussian.hpp"

#include <algorithm>

#include "ipm_mapping/kernels/chain_segment.hpp"

namespace ipm_mapping {

void Gaussian::operator()(GrayView image, GrayView valid, GrayBuffer blurred,
                          GrayBuffer blurred_valid) {
  const int W = image.width, H = image.height;
  column_sums_.resize(static_cast<std::size_t>(W));
  for (int v = 0; v < H; ++v) {
    if (v == 0 || v == H - 1) {
      std::fill_n(blurred.row(v), W, std::uint8_t{0});
      std::fill_n(blurred_valid.row(v), W, std::uint8_t{0});
    } else {
      kernels::blurRow(image.row(v - 1), image.row(v), image.row(v + 1), valid.row(v), W,
                       column_sums_.data(), blurred.row(v), blurred_valid.row(v));
    }
  }
}

}  // namespace ipm_mapping

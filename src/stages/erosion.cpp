#include "ipm_mapping/stages/erosion.hpp"

#include <algorithm>

#include "ipm_mapping/kernels/chain_segment.hpp"

namespace ipm_mapping {

void Erosion::operator()(GrayView binary, GrayBuffer eroded) {
  const int W = binary.width, H = binary.height;
  columns_.resize(static_cast<std::size_t>(W));
  for (int v = 0; v < H; ++v) {
    if (v == 0 || v == H - 1)
      std::fill_n(eroded.row(v), W, std::uint8_t{0});
    else
      kernels::erodeRow(binary.row(v - 1), binary.row(v), binary.row(v + 1), W, columns_.data(),
                        eroded.row(v));
  }
}

}  // namespace ipm_mapping

#include "ipm_mapping/fpga/erosion.hpp"

namespace ipm_mapping::fpga {
namespace {

bool allOnes(ImageView<const std::uint8_t> mask, int u, int v) {
  for (int dv = -1; dv <= 1; ++dv) {
    for (int du = -1; du <= 1; ++du) {
      if (!mask.contains(u + du, v + dv) || !mask.at(u + du, v + dv)) return false;
    }
  }
  return true;
}

}  // namespace

void erosion(ImageView<const std::uint8_t> mask, ImageView<std::uint8_t> out) {
  for (int v = 0; v < out.height; ++v) {
    for (int u = 0; u < out.width; ++u) out.at(u, v) = allOnes(mask, u, v) ? 1 : 0;
  }
}

}  // namespace ipm_mapping::fpga

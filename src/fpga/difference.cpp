#include "ipm_mapping/fpga/difference.hpp"

#include "ipm_mapping/fpga/undistort_warp.hpp"

namespace ipm_mapping::fpga {

TaggedPixel absoluteDifference(std::uint8_t reference, std::uint8_t current) {
  const auto d = formats::Pixel::fromRaw(reference) - formats::Pixel::fromRaw(current);
  return static_cast<TaggedPixel>(d.raw() < 0 ? -d.raw() : d.raw());
}

void difference(const FrameInputs& inputs, ImageView<TaggedPixel> out, OverflowCounters& counters) {
  const UndistortWarp warp(inputs.parameters);
  for (int v = 0; v < out.height; ++v) {
    for (int u = 0; u < out.width; ++u) {
      const auto r = warp.reference(u, v, counters);
      const auto c = warp.current(u, v, counters);
      out.at(u, v) = r && c ? absoluteDifference(inputs.reference.at(r->u, r->v),
                                                 inputs.current.at(c->u, c->v))
                            : no_correspondence;
    }
  }
}

}  // namespace ipm_mapping::fpga

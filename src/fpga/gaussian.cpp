#include "ipm_mapping/fpga/gaussian.hpp"

#include <algorithm>

namespace ipm_mapping::fpga {
namespace {

/// The value that a pixel brings into a sum (rule 7).
formats::Pixel term(TaggedPixel pixel) {
  return formats::Pixel::fromRaw(pixel & no_correspondence ? 0 : pixel);
}

template <int Shift>
auto shifted(TaggedPixel pixel) {
  return Unsigned<8 - Shift>::fromRaw(term(pixel).raw() >> Shift);
}

/// Rule 8: >>4 at the corners, >>3 at the edges, >>2 in the centre.
TaggedPixel convolve(const TaggedPixel* above, const TaggedPixel* row, const TaggedPixel* below) {
  const auto corners =
      shifted<4>(above[-1]) + shifted<4>(above[1]) + shifted<4>(below[-1]) + shifted<4>(below[1]);
  const auto edges =
      shifted<3>(above[0]) + shifted<3>(row[-1]) + shifted<3>(row[1]) + shifted<3>(below[0]);
  return static_cast<TaggedPixel>((corners + edges + shifted<2>(row[0])).raw());
}

}  // namespace

void gaussian(ImageView<const TaggedPixel> in, ImageView<TaggedPixel> out) {
  for (int v = 0; v < out.height; ++v) {
    std::fill_n(out.row(v), out.width, no_correspondence);
    if (v == 0 || v == out.height - 1) continue;
    for (int u = 1; u < out.width - 1; ++u) {
      if (in.at(u, v) & no_correspondence) continue;
      out.at(u, v) = convolve(in.row(v - 1) + u, in.row(v) + u, in.row(v + 1) + u);
    }
  }
}

}  // namespace ipm_mapping::fpga

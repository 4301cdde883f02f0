#include "ipm_mapping/fpga/otsu.hpp"

#include <algorithm>

#include "ipm_mapping/fpga/frame_parameters.hpp"

namespace ipm_mapping::fpga {
namespace {

using formats::BinCount;
using formats::GreySum;

struct Totals {
  BinCount count;
  GreySum grey;
};

/// tot and S1: at most 640 * 480 pixels, so that neither register can overflow (rule 13).
Totals totals(const GreyHistogram& bins) {
  Integer count = 0, grey = 0;
  for (int k = 0; k < 256; ++k) {
    count += bins[static_cast<std::size_t>(k)];
    grey += Integer{k} * bins[static_cast<std::size_t>(k)];
  }
  return {BinCount::fromRaw(count), GreySum::fromRaw(grey)};
}

/// w0 w1 (mu1 - mu0)^2 with integer means (eq. 3.30); both classes are occupied.
formats::Variance betweenClasses(Integer w0, Integer sub, const Totals& all) {
  const Integer w1 = all.count.raw() - w0;
  const auto mu0 = formats::Pixel::fromRaw(sub / w0);
  const auto mu1 = formats::Pixel::fromRaw((all.grey.raw() - sub) / w1);
  const auto weight = widen<formats::WeightProduct>(BinCount::fromRaw(w0) * BinCount::fromRaw(w1));
  const auto step = Unsigned<8>::fromRaw(mu1.raw() - mu0.raw());
  return widen<formats::Variance>(weight * (step * step));
}

}  // namespace

void histogram(ImageView<const TaggedPixel> gaussian, GreyHistogram& bins) {
  bins.fill(0);
  for (int v = 0; v < gaussian.height; ++v) {
    for (int u = 0; u < gaussian.width; ++u) {
      const TaggedPixel pixel = gaussian.at(u, v);
      if (!(pixel & no_correspondence)) ++bins[pixel];
    }
  }
}

std::optional<std::uint8_t> otsuThreshold(const GreyHistogram& bins) {
  const Totals all = totals(bins);
  Integer w0 = 0, sub = 0, best = 0;
  std::optional<std::uint8_t> threshold;
  for (int k = 0; k < 256; ++k) {
    w0 += bins[static_cast<std::size_t>(k)];
    sub += Integer{k} * bins[static_cast<std::size_t>(k)];
    if (w0 == 0 || w0 == all.count.raw()) continue;
    const Integer variance = betweenClasses(w0, sub, all).raw();
    if (variance <= best) continue;
    best = variance;
    threshold = static_cast<std::uint8_t>(k);
  }
  return threshold;
}

int maskThreshold(int threshold_in, int min_threshold) {
  return std::max(threshold_in, min_threshold);
}

void binarise(ImageView<const TaggedPixel> gaussian, int threshold, ImageView<std::uint8_t> mask) {
  for (int v = 0; v < mask.height; ++v) {
    for (int u = 0; u < mask.width; ++u) {
      const TaggedPixel pixel = gaussian.at(u, v);
      mask.at(u, v) = !(pixel & no_correspondence) && pixel > threshold ? 1 : 0;
    }
  }
}

}  // namespace ipm_mapping::fpga

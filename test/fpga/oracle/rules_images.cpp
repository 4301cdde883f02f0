// Rules 7 to 9: difference, 3x3 stages, threshold.

#include <algorithm>
#include <cstdlib>

#include "rules.hpp"

namespace oracle {
namespace {

constexpr uint16_t no_correspondence = 0x100;

size_t at(const Params& p, int u, int v) { return static_cast<size_t>(v * p.width + u); }

bool onBorder(const Params& p, int u, int v) {
  return u == 0 || v == 0 || u == p.width - 1 || v == p.height - 1;
}

}  // namespace

/// Rule 7.
std::vector<uint16_t> difference(const Inputs& in, const AddressImage& reference,
                                 const AddressImage& current) {
  std::vector<uint16_t> out;
  for (size_t i = 0; i < reference.size(); ++i) {
    if (!reference[i].valid || !current[i].valid) {
      out.push_back(no_correspondence);
      continue;
    }
    const int r = in.reference[at(in.params, reference[i].u, reference[i].v)];
    const int c = in.current[at(in.params, current[i].u, current[i].v)];
    out.push_back(static_cast<uint16_t>(std::abs(r - c)));
  }
  return out;
}

/// Rules 7 and 8: every term is shifted before the sum, an invalid pixel enters as 0.
std::vector<uint16_t> gaussian(const Params& p, const std::vector<uint16_t>& difference) {
  constexpr int shift[3][3] = {{4, 3, 4}, {3, 2, 3}, {4, 3, 4}};
  std::vector<uint16_t> out(difference.size(), no_correspondence);
  for (int v = 0; v < p.height; ++v) {
    for (int u = 0; u < p.width; ++u) {
      if (onBorder(p, u, v) || difference[at(p, u, v)] == no_correspondence) continue;
      int sum = 0;
      for (int j = -1; j <= 1; ++j) {
        for (int i = -1; i <= 1; ++i) {
          const int pixel = difference[at(p, u + i, v + j)];
          sum += (pixel == no_correspondence ? 0 : pixel) >> shift[j + 1][i + 1];
        }
      }
      out[at(p, u, v)] = static_cast<uint16_t>(sum);
    }
  }
  return out;
}

/// Rule 9, first sentence.
std::vector<int64_t> histogram(const std::vector<uint16_t>& gaussian) {
  std::vector<int64_t> bins(256, 0);
  for (const uint16_t pixel : gaussian) {
    if ((pixel >> 8) == 0) ++bins[pixel];
  }
  return bins;
}

/// Rule 9, mask: with the register as it was before this frame.
std::vector<uint8_t> binarise(const Params& p, const std::vector<uint16_t>& gaussian) {
  const int threshold = std::max(p.threshold_in, p.min_threshold);
  std::vector<uint8_t> mask;
  for (const uint16_t pixel : gaussian) {
    mask.push_back((pixel >> 8) == 0 && pixel > threshold ? 1 : 0);
  }
  return mask;
}

/// Rule 9, threshold. Each class is summed anew for each k.
int otsu(int threshold_in, const std::vector<int64_t>& histogram, Wires& w) {
  int threshold = threshold_in;
  Int best = 0;
  for (int k = 0; k <= 255; ++k) {
    Int count[2] = {0, 0}, sum[2] = {0, 0};
    for (int grey = 0; grey <= 255; ++grey) {
      const int which = grey <= k ? 0 : 1;
      count[which] += histogram[static_cast<size_t>(grey)];
      sum[which] += Int{grey} * histogram[static_cast<size_t>(grey)];
    }
    if (count[0] == 0 || count[1] == 0) continue;
    const Int apart = sum[1] / count[1] - sum[0] / count[0];
    const Int variance = count[0] * count[1] * apart * apart;
    if (variance == best && best > 0) ++w.events[OtsuTie];
    if (variance <= best) continue;
    best = variance;
    threshold = k;
  }
  if (best == 0) ++w.events[ThresholdKept];
  return threshold;
}

/// Rule 8, erosion: all nine ones; border pixels are 0.
std::vector<uint8_t> erode(const Params& p, const std::vector<uint8_t>& mask) {
  std::vector<uint8_t> out(mask.size(), 0);
  for (int v = 0; v < p.height; ++v) {
    for (int u = 0; u < p.width; ++u) {
      if (onBorder(p, u, v)) continue;
      int ones = 0;
      for (int j = -1; j <= 1; ++j) {
        for (int i = -1; i <= 1; ++i) ones += mask[at(p, u + i, v + j)];
      }
      if (ones == 9) out[at(p, u, v)] = 1;
    }
  }
  return out;
}

}  // namespace oracle

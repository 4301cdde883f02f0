#include "ipm_mapping/stages/otsu.hpp"

#include <cstring>

#include "ipm_mapping/kernels/chain_segment.hpp"

namespace ipm_mapping {
namespace {

// Neighbouring pixels are often equal: eight tables keep an increment from waiting for the one
// before it.
constexpr int tables = 8;
using Tables = std::array<Histogram, tables>;

void addRow(const std::uint8_t* image, int width, Tables& counts) {
  int u = 0;
  for (; u + tables <= width; u += tables) {
    std::uint64_t pixels = 0;
    std::memcpy(&pixels, image + u, sizeof pixels);
    if (pixels == 0) {  // where nothing is valid, and on plain floor
      counts[0][0] += tables;
      continue;
    }
    for (Histogram& table : counts) {
      ++table[pixels & 0xFF];
      pixels >>= 8;
    }
  }
  for (; u < width; ++u) ++counts[0][image[u]];
}

}  // namespace

Histogram histogramOf(GrayView image, GrayView valid) {
  Tables counts{};
  std::uint32_t invalid = 0;
  for (int v = 0; v < image.height; ++v) {
    addRow(image.row(v), image.width, counts);
    invalid +=
        static_cast<std::uint32_t>(image.width - kernels::countNonZero(valid.row(v), image.width));
  }
  Histogram sum{};
  for (const Histogram& table : counts)
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += table[k];
  sum[0] -= invalid;
  return sum;
}

std::optional<Otsu> otsu(const Histogram& histogram) {
  double n = 0, total = 0, squares = 0;
  for (std::size_t k = 0; k < histogram.size(); ++k) {
    const auto grey = static_cast<double>(k), count = static_cast<double>(histogram[k]);
    n += count;
    total += grey * count;
    squares += grey * grey * count;
  }
  // w0 w1 (mu1 - mu0)^2 = (total w0 - n sum0)^2 / (w0 w1): numerator and denominator are integers
  // that doubles hold exactly up to images of 5 megapixels, so that equal candidates compare equal.
  double best = 0.0, w0 = 0.0, sum0 = 0.0;
  int threshold = -1;
  for (std::size_t k = 0; k < histogram.size(); ++k) {
    w0 += static_cast<double>(histogram[k]);
    sum0 += static_cast<double>(k) * static_cast<double>(histogram[k]);
    const double w1 = n - w0;
    if (w0 == 0.0 || w1 == 0.0) continue;
    const double difference = total * w0 - n * sum0;
    const double between = difference * difference / (w0 * w1);
    if (between > best) {
      best = between;
      threshold = static_cast<int>(k);
    }
  }
  if (threshold < 0) return std::nullopt;
  return Otsu{threshold, best / (n * squares - total * total)};
}

void binarize(GrayView image, GrayView valid, int threshold, GrayBuffer binary) {
  for (int v = 0; v < image.height; ++v)
    kernels::binarizeRow(image.row(v), valid.row(v), threshold, image.width, binary.row(v));
}

}  // namespace ipm_mapping

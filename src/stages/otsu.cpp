#include "ipm_mapping/stages/otsu.hpp"

namespace ipm_mapping {
namespace {

// Neighbouring pixels are often equal: four tables keep an increment from waiting for the one
// before it.
using Tables = std::array<Histogram, 4>;

void addRow(const std::uint8_t* image, const std::uint8_t* valid, int width, Tables& tables) {
  for (int u = 0; u < width; ++u)
    tables[static_cast<std::size_t>(u) & 3U][image[u]] += valid[u] != 0 ? 1U : 0U;
}

}  // namespace

Histogram histogramOf(GrayView image, GrayView valid) {
  Tables tables{};
  for (int v = 0; v < image.height; ++v) addRow(image.row(v), valid.row(v), image.width, tables);
  Histogram sum{};
  for (std::size_t k = 0; k < sum.size(); ++k)
    sum[k] = tables[0][k] + tables[1][k] + tables[2][k] + tables[3][k];
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
  for (int v = 0; v < image.height; ++v) {
    const std::uint8_t* in = image.row(v);
    const std::uint8_t* seen = valid.row(v);
    std::uint8_t* out = binary.row(v);
    for (int u = 0; u < image.width; ++u)
      out[u] = static_cast<std::uint8_t>(in[u] > threshold && seen[u] ? 255 : 0);
  }
}

}  // namespace ipm_mapping

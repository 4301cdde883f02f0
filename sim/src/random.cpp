#include "ipm_mapping_sim/random.hpp"

#include <array>
#include <cmath>

namespace ipm_mapping::sim {
namespace {

constexpr int kTableBits = 12;
constexpr int kTableSize = 1 << kTableBits;

double normalCdf(double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); }

/// Inverse of the normal distribution function by bisection: only used to fill the table.
double normalQuantile(double p) {
  double low = -6.0, high = 6.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (normalCdf(middle) < p ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

std::array<float, kTableSize + 1> quantiles() {
  std::array<float, kTableSize + 1> table{};
  for (int i = 0; i <= kTableSize; ++i) {
    const double p = (i + 0.5 * (i == 0) - 0.5 * (i == kTableSize)) / kTableSize;
    table[static_cast<std::size_t>(i)] = static_cast<float>(normalQuantile(p));
  }
  return table;
}

}  // namespace

float normalFloat(std::uint32_t bits24) {
  static const std::array<float, kTableSize + 1> table = quantiles();
  constexpr std::uint32_t fraction_bits = 24 - kTableBits;
  const std::uint32_t i = (bits24 & 0xFFFFFFU) >> fraction_bits;
  const std::uint32_t rest = bits24 & ((1U << fraction_bits) - 1U);
  const float t = static_cast<float>(rest) / static_cast<float>(1U << fraction_bits);
  return table[i] + t * (table[i + 1] - table[i]);
}

}  // namespace ipm_mapping::sim

#pragma once
// Bodies of the fast engine's pixel and line kernels: rules 7-9, 11 and 12 for a row.

#include <cstring>

#include "fast_warp_body.hpp"

namespace ipm_mapping::fpga::body {

/// valid: of the reference on entry, of both streams on return.
FPGA_INLINE void difference(const std::uint8_t* reference, const std::int32_t* offsets,
                            const std::uint8_t* current, const std::uint8_t* current_valid,
                            int width, std::uint8_t* out, std::uint8_t* valid) {
  alignas(64) std::uint8_t sampled[row_capacity];
#pragma GCC unroll 16
  for (int u = 0; u < width; ++u) sampled[u] = reference[offsets[u]];
  for (int u = 0; u < width; ++u) {
    const std::uint8_t a = sampled[u], b = current[u];
    const auto d = static_cast<std::uint8_t>(a > b ? a - b : b - a);
    const auto ok = static_cast<std::uint8_t>(valid[u] & current_valid[u]);
    valid[u] = ok;
    out[u] = d & ok;
  }
}

/// Sums of at most 4 * 15 + 4 * 31 + 63 = 247 stay in 8 bits.
FPGA_INLINE void gaussian(const std::uint8_t* above, const std::uint8_t* row,
                          const std::uint8_t* below, const std::uint8_t* valid, int width,
                          std::uint8_t* out) {
  alignas(64) std::uint8_t outer[row_capacity];
  alignas(64) std::uint8_t inner[row_capacity];
  for (int u = 0; u < width; ++u) {
    const std::uint8_t a = above[u], b = row[u], c = below[u];
    outer[u] = static_cast<std::uint8_t>((a >> 4) + (b >> 3) + (c >> 4));
    inner[u] = static_cast<std::uint8_t>((a >> 3) + (b >> 2) + (c >> 3));
  }
  for (int u = 1; u < width - 1; ++u) {
    const auto sum = static_cast<std::uint8_t>(outer[u - 1] + inner[u] + outer[u + 1]);
    out[u] = valid[u] ? sum : invalid_grey;
  }
  out[0] = invalid_grey;
  out[width - 1] = invalid_grey;
}

/// Eight bytes of 0 or 1, lowest first, to eight bits.
FPGA_INLINE std::uint64_t packedBits(const std::uint8_t* bytes) {
  std::uint64_t eight;
  std::memcpy(&eight, bytes, 8);
  return eight * 0x0102040810204080ULL >> 56;
}

FPGA_INLINE void binarise(const std::uint8_t* gaussian, int threshold, int width, BitRow& bits) {
  alignas(64) std::uint8_t above[row_capacity];
  const auto limit = static_cast<std::uint8_t>(threshold);
  for (int u = 0; u < width; ++u) {
    above[u] = gaussian[u] > limit && gaussian[u] != invalid_grey ? 1 : 0;
  }
  for (int u = width; u < ((width + 63) & ~63); ++u) above[u] = 0;
  std::memset(bits.words, 0, sizeof bits.words);
  for (int w = 0; w < (width + 63) / 64; ++w) {
    std::uint64_t word = 0;
    for (int b = 0; b < 8; ++b) word |= packedBits(above + 64 * w + 8 * b) << (8 * b);
    bits.words[w + 1] = word;
  }
}

/// Number of ones in 11 bits.
FPGA_INLINE std::int32_t ones(std::int32_t bits) {
  bits = bits - (bits >> 1 & 0x555);
  bits = (bits & 0x333) + (bits >> 2 & 0x333);
  return (bits & 0xf) + (bits >> 4 & 0xf) + (bits >> 8);
}

/// Rule 12 for line i. Nothing can saturate: with at most 480 rows S stays below 5281, h and |Sc|
/// below 481.
FPGA_INLINE void contactStep(const MachineConstants& c, int v, LineRegisters& r, int i) {
  const std::int32_t window = r.window[i];
  const bool pixel = (window >> window_half_width & 1) != 0;
  const std::int32_t a = ones(window);
  const bool narrower = a <= r.smallest[i];
  const bool contact =
      r.score[i] > c.score_min && r.surface[i] > 4 * r.height[i] && r.height[i] >= c.min_height;
  const std::int32_t widened_score = c.triangle ? r.score[i] - 1 : 0;
  const std::int32_t widened_surface = c.triangle ? r.surface[i] : 0;
  const std::int32_t widened_height = c.triangle ? r.height[i] : 0;
  r.found[i] = !pixel && contact ? r.stored[i] : r.found[i];
  r.stored[i] = pixel && narrower ? r.u[i] * 512 + v : r.stored[i];
  const std::int32_t score = narrower ? r.score[i] + 1 : widened_score;
  const std::int32_t surface = narrower ? r.surface[i] + a : widened_surface;
  const std::int32_t height = narrower ? r.height[i] + 1 : widened_height;
  r.smallest[i] = pixel && narrower ? a : 2 * window_half_width + 1;
  r.score[i] = pixel ? score : 0;
  r.surface[i] = pixel ? surface : 0;
  r.height[i] = pixel ? height : 0;
  r.bear[i] += pixel ? 1 : 0;
}

/// Columns this far outside the image read nothing but zeros.
constexpr int outside = 32;

/// Eleven bits around each line's column.
FPGA_INLINE void extractWindows(const BitRow& bits, LineRegisters& r) {
  const auto* bytes = reinterpret_cast<const unsigned char*>(bits.words);
  for (int i = 0; i < line_count; ++i) {
    const int u = std::min(std::max(r.u[i], -outside), max_width + outside);
    const int first = u - window_half_width + 64;
    std::uint32_t word;
    std::memcpy(&word, bytes + first / 8, sizeof word);
    r.window[i] = static_cast<std::int32_t>(word >> (first % 8) & 0x7ff);
  }
}

FPGA_INLINE std::int64_t localize(const MachineConstants& c, int v, const BitRow& bits,
                                  LineRegisters& r) {
  std::int32_t saturated = 0;
  extractWindows(bits, r);
  for (int i = 0; i < line_count; ++i) contactStep(c, v, r, i);
  for (int i = 0; i < line_count; ++i) {
    const bool steps = r.d[i] > 0;
    const std::int32_t d = r.d[i] + (steps ? r.up[i] : r.flat[i]);
    const std::int32_t high = d > 262143 ? 262143 : d;
    const std::int32_t limited = high < -262144 ? -262144 : high;
    saturated += limited != d ? 1 : 0;
    r.u[i] += steps ? r.direction[i] : 0;
    r.d[i] = limited;
  }
  return saturated;
}

}  // namespace ipm_mapping::fpga::body

#pragma once
// Bodies of the fast engine's coordinate kernels: rules 3, 4 and 5 for a row. Included once and
// inlined into one function per instruction set.

#include <algorithm>
#include <cstdint>

#include "ipm_mapping/fpga/fast_kernels.hpp"

#define FPGA_INLINE inline __attribute__((always_inline))

namespace ipm_mapping::fpga::body {

/// Beyond every 12.6 coordinate and every 20-bit normalised one: what a clamped estimate becomes.
constexpr float beyond_view = 132000.0F;
constexpr float beyond_normalized = 600000.0F;

/// Exact magnitude << shift / divisor from a float estimate that is off by less than one: the
/// remainder is small, so that 32 bits of it are enough.
FPGA_INLINE std::int32_t exactQuotient(std::uint32_t magnitude, int shift, std::int32_t divisor,
                                       float scale, float beyond) {
  const float estimate = static_cast<float>(static_cast<std::int32_t>(magnitude)) * scale;
  std::int32_t q = static_cast<std::int32_t>(estimate < beyond ? estimate : beyond);
  const auto remainder = static_cast<std::int32_t>(
      (magnitude << shift) - static_cast<std::uint32_t>(q) * static_cast<std::uint32_t>(divisor));
  q += remainder >= divisor ? 1 : 0;
  q -= remainder < 0 ? 1 : 0;
  return q;
}

/// The same for a signed numerator: truncation toward 0.
FPGA_INLINE std::int32_t signedQuotient(std::int32_t numerator, int shift, std::int32_t divisor,
                                        float scale, float beyond) {
  const std::int32_t sign = numerator >> 31;
  const auto magnitude = static_cast<std::uint32_t>((numerator ^ sign) - sign);
  return (exactQuotient(magnitude, shift, divisor, scale, beyond) ^ sign) - sign;
}

FPGA_INLINE std::int32_t maskOf(bool condition) { return condition ? -1 : 0; }

FPGA_INLINE std::int32_t inView(std::int32_t x) {
  return maskOf(x >= -131072) & maskOf(x <= 131071);
}

/// Rule 3, u and v integers.
FPGA_INLINE void homography(const HomographyRow& h, int width, CoordinateRow& out) {
  for (int u = 0; u < width; ++u) {
    const std::int32_t d = h.d + h.d_step * u;
    const std::int32_t divisor = d > 0 ? d : 1;
    const float scale = 64.0F / static_cast<float>(divisor);
    const std::int32_t x = signedQuotient(h.nx + h.nx_step * u, 6, divisor, scale, beyond_view);
    const std::int32_t y = signedQuotient(h.ny + h.ny_step * u, 6, divisor, scale, beyond_view);
    out.x[u] = x;
    out.y[u] = y;
    out.valid[u] =
        maskOf(d > 0) & inView(x) & inView(y) & maskOf(h.horizon + h.horizon_step * u > 0);
  }
}

/// Rule 3 of 12.6 coordinates. The operands stay below 2^43: double division truncates exactly.
FPGA_INLINE void wideHomography(const WideHomography& w, int width, CoordinateRow& row) {
  const auto clamp = [](double q) { return std::min(std::max(q, -200000.0), 200000.0); };
  for (int u = 0; u < width; ++u) {
    const double x = row.x[u], y = row.y[u];
    const double d = static_cast<double>(w.h[6]) * x + static_cast<double>(w.h[7]) * y +
                     static_cast<double>(w.h[8]);
    const double divisor = d > 0.0 ? d : 1.0;
    const double nx = static_cast<double>(w.h[0]) * x + static_cast<double>(w.h[1]) * y +
                      static_cast<double>(w.h[2]);
    const double ny = static_cast<double>(w.h[3]) * x + static_cast<double>(w.h[4]) * y +
                      static_cast<double>(w.h[5]);
    const auto qx = static_cast<std::int32_t>(clamp(nx * 64.0 / divisor));
    const auto qy = static_cast<std::int32_t>(clamp(ny * 64.0 / divisor));
    row.x[u] = qx;
    row.y[u] = qy;
    row.valid[u] &= maskOf(d > 0.0) & inView(qx) & inView(qy);
  }
}

/// Rule 4: xn or yn of one coordinate, saturated; adds to count when a valid pixel saturates.
FPGA_INLINE std::int32_t normalized(std::int32_t coordinate, std::int32_t centre, std::int32_t f,
                                    float scale, std::int32_t valid, std::int32_t& count) {
  const std::int32_t q = signedQuotient(coordinate - centre, 16, f, scale, beyond_normalized);
  const std::int32_t high = q > 524287 ? 524287 : q;
  const std::int32_t limited = high < -524288 ? -524288 : high;
  count += valid & (limited != q ? 1 : 0);
  return limited;
}

FPGA_INLINE void normalizeRow(const LensConstants& c, int width, CoordinateRow& row,
                              LensCounts& counts) {
  std::int32_t xn = 0, yn = 0;
  for (int u = 0; u < width; ++u) {
    const std::int32_t valid = row.valid[u];
    row.x[u] = normalized(row.x[u], c.cx, c.fx, c.x_scale, valid, xn);
    row.y[u] = normalized(row.y[u], c.cy, c.fy, c.y_scale, valid, yn);
  }
  counts.xn += xn;
  counts.yn += yn;
}

/// a * b >> 16 in Int: 32 bits are enough where the caller has proved it.
template <class Int>
FPGA_INLINE Int scaled(Int a, Int b) {
  const std::int64_t product = static_cast<std::int64_t>(a) * b;
  if constexpr (sizeof(Int) == 8) return product >> 16;
  return static_cast<Int>(static_cast<std::uint64_t>(product) >> 16);
}

/// a + b; wraps for pixels beyond the turning radius, which are invalid.
template <class Int>
FPGA_INLINE Int sum(Int a, Int b) {
  if constexpr (sizeof(Int) == 8) return a + b;
  return static_cast<Int>(static_cast<std::uint32_t>(a) + static_cast<std::uint32_t>(b));
}

/// A raw coordinate as 32 bits; what lies outside every frame stays outside.
template <class Int>
FPGA_INLINE std::int32_t narrowed(Int coordinate) {
  constexpr Int limit = 1 << 30;
  if constexpr (sizeof(Int) == 4) return coordinate;
  return static_cast<std::int32_t>(coordinate < -limit  ? -limit
                                   : coordinate > limit ? limit
                                                        : coordinate);
}

template <class Int>
FPGA_INLINE void distortRow(const LensConstants& c, int width, CoordinateRow& row) {
  const Int k1 = c.k1, k2 = c.k2, k3 = c.k3, one = 65536;
  const Int fx = c.fx, fy = c.fy, cx = c.cx, cy = c.cy;
  for (int u = 0; u < width; ++u) {
    const Int xn = row.x[u], yn = row.y[u];
    const std::int64_t squares =
        static_cast<std::int64_t>(xn) * xn + static_cast<std::int64_t>(yn) * yn;
    const Int r2 = static_cast<Int>(static_cast<std::uint64_t>(squares) >> 16);
    Int p = sum(scaled(k3, r2), k2);
    p = sum(scaled(p, r2), k1);
    p = sum(scaled(p, r2), one);
    row.x[u] = narrowed<Int>(sum(scaled(scaled(xn, p), fx), cx));
    row.y[u] = narrowed<Int>(sum(scaled(scaled(yn, p), fy), cy));
    row.valid[u] &= maskOf(r2 <= c.r2_max);
  }
}

FPGA_INLINE void lens(const LensConstants& c, int width, CoordinateRow& row, LensCounts& counts) {
  normalizeRow(c, width, row, counts);
  if (c.narrow) {
    distortRow<std::int32_t>(c, width, row);
  } else {
    distortRow<std::int64_t>(c, width, row);
  }
}

/// Rule 5. Pixels without an address get offset 0.
FPGA_INLINE std::int64_t address(const AddressConstants& c, const CoordinateRow& row,
                                 std::int32_t* offsets, std::uint8_t* valid_bytes) {
  std::int32_t near_write = 0;
  for (int u = 0; u < c.width; ++u) {
    const std::int32_t ui = (row.x[u] + 32) >> 6;
    const std::int32_t vi = (row.y[u] + 32) >> 6;
    const std::int32_t valid = row.valid[u] & maskOf(ui >= 0) & maskOf(ui < c.width) &
                               maskOf(vi >= 0) & maskOf(vi < c.height);
    offsets[u] = valid & (static_cast<std::int32_t>(static_cast<std::uint32_t>(vi) *
                                                        static_cast<std::uint32_t>(c.stride) +
                                                    static_cast<std::uint32_t>(ui)));
    valid_bytes[u] = static_cast<std::uint8_t>(valid);
    near_write += valid & (vi < c.near_write_below ? 1 : 0);
  }
  return near_write;
}

/// Rules 3-5 of a row.
FPGA_INLINE std::int64_t warp(const HomographyRow& h, const LensConstants& l,
                              const AddressConstants& a, CoordinateRow& scratch,
                              std::int32_t* offsets, std::uint8_t* valid, LensCounts& counts) {
  homography(h, a.width, scratch);
  lens(l, a.width, scratch, counts);
  return address(a, scratch, offsets, valid);
}

}  // namespace ipm_mapping::fpga::body

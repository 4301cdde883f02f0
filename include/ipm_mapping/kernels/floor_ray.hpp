#pragma once
// Where the floor points of one azimuth are seen from another place. Single precision, every
// operation correctly rounded and none fused: every SIMD target gives the same bits.

#include <cstdint>

namespace ipm_mapping::kernels {

/// The floor point at distance d along a ray lies at d u + t around the other view's foot.
struct FloorRay {
  float ux = 1.0F, uy = 0.0F;  ///< unit vector
  float tx = 0.0F, ty = 0.0F;  ///< metres
  float rows_per_log = 1.0F;
  float lines_per_radian = 1.0F;
  float line_ahead = 0.0F;  ///< line of azimuth 0
};

/// For points at distance 1 / inverse[i], with (x, y) = u + t / d:
///   shift[i] = -rows_per_log ln |(x, y)|, rows by which the point is seen nearer,
///   line[i] = line_ahead - lines_per_radian atan2(y, x);
/// errors stay below 0.002 for scales up to 400. All arrays hold `overrun` elements more.
void rayPositions(const FloorRay& ray, const float* inverse, int count, float* line, float* shift);

/// Takes positions of magnitude below 2^30 apart: position = whole + fraction / 32767, rounded
/// down.
void splitPositions(const float* position, int count, std::int32_t* whole, std::int32_t* fraction);

}  // namespace ipm_mapping::kernels

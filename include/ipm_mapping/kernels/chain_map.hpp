#pragma once
// One row of a warp: which raw pixels its pixels show. Every instruction set gives the same bits:
// the order of the floating-point operations is fixed.

#include <array>
#include <vector>

#include "ipm_mapping/kernels/chain_samples.hpp"

namespace ipm_mapping::kernels {

/// plumb_bob in single precision.
struct Lens {
  float fx, fy, cx, cy;
  float k1, k2, p1, p2, k3;
  float turning_radius_squared;
  int width, height;
};

/// A row of pixels as rays of the reference camera: (x, y, z) + u (dx, dy, dz), and the inverse
/// depth of their floor points in the current view.
struct RayRow {
  float x, y, z, inverse_depth;
  float dx, dy, dz, d_inverse_depth;
};

/// Exact raw coordinates of every pixel of one row; NaN near or beyond what makes a pixel invalid
/// (a pixel from the picture's border, the turning radius, the horizon).
struct KeyRow {
  std::vector<float> u, v;
};
void mapKeyRow(const RayRow& rays, const Lens& lens, KeyRow& key);

/// Three key rows and their weights for a row between them.
struct KeyRows {
  std::array<const KeyRow*, 3> rows;
  std::array<float, 3> weights;
};

/// Fills a row with the raw pixels that its rays meet through the lens: outside the picture where z
/// or the inverse depth is not positive, beyond the turning radius, or more than half a step
/// outside the picture. Interpolates where all three key rows have coordinates; exact elsewhere,
/// and everywhere without key rows.
void mapRow(const RayRow& rays, const KeyRows* keys, const Lens& lens, const Samples::Row& samples,
            int padded_width);

}  // namespace ipm_mapping::kernels

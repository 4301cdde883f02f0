#pragma once
// Bodies of the motion refinement. Single precision, every operation correctly rounded and in a
// fixed order: sums run in `alignment_lanes` strands whatever the width of a vector, and no product
// is fused into a sum, so that every SIMD target gives the same bits.

#include <cstdint>

#include "ipm_mapping/image_view.hpp"

namespace ipm_mapping::kernels {

inline constexpr int alignment_lanes = 8;
/// What moves the samples: x, y, theta of the base, pitch and roll of the sway.
inline constexpr int alignment_moves = 5;
/// Those, gain and offset.
inline constexpr int alignment_unknowns = alignment_moves + 2;
/// Terms of the normal equations: J^T w e, then the upper triangle of J^T w J row by row.
inline constexpr int alignment_sums =
    alignment_unknowns + alignment_unknowns * (alignment_unknowns + 1) / 2;

/// From floor points around the current foot to pixels of the reference.
struct FloorProjection {
  float c = 1.0F, s = 0.0F, tx = 0.0F, ty = 0.0F;    ///< p_reference = R p + t
  float foot_x = 0.0F, foot_y = 0.0F;                ///< the camera's foot in base
  float height = 1.0F;                               ///< of the camera
  float rows_per_log = 1.0F, row_at_one = 0.0F;      ///< row = row_at_one - rows_per_log ln |p|
  float lines_per_radian = 1.0F, line_ahead = 0.0F;  ///< line = line_ahead - lines_per_radian atan2
};

/// Where floor points are seen in the reference, and how that moves with x, y, theta, and with
/// pitch and roll of the robot in the reference against now. Arrays hold `overrun` elements more
/// than are used.
struct SamplePositions {
  float* row = nullptr;
  float* line = nullptr;
  float* d_row[alignment_moves] = {};
  float* d_line[alignment_moves] = {};
};

/// Projects `count` floor points; errors stay below 0.002 of a row or line for
/// rows_per_log, lines_per_radian <= 400.
void projectFloor(const float* x, const float* y, int count, const FloorProjection& projection,
                  const SamplePositions& out);

/// The reference at the samples: bilinear grey level, the same minus the local mean, and its
/// derivatives by what moves the samples.
struct WarpedSamples {
  float* grey = nullptr;
  float* high = nullptr;
  float* gradient[alignment_moves] = {};
};

/// Samples the reference at positions moved by a correction of x, y, theta, pitch and roll;
/// positions outside stop at the border.
void warpSamples(ImageView<const std::uint8_t> reference, const SamplePositions& at,
                 const float* mean, const float* correction, int count, const WarpedSamples& out);

/// One brightness model over samples: e = current - (gain warped + offset).
struct AlignmentResidual {
  const float* current = nullptr;
  const float* warped = nullptr;
  float gain = 1.0F, offset = 0.0F;
  int count = 0;
};

/// Normal equations with J = (gradients, warped, 1) and Tukey's weight
/// w = max(0, 1 - (e / limit)^2)^2.
void alignmentSums(const AlignmentResidual& residual, const float* const* gradient, float limit,
                   double* sums);

/// Median of |e| to `most` / 1024, or `most` where it is more. `scratch` holds count elements.
float medianDeviation(const AlignmentResidual& residual, float most, float* scratch);

}  // namespace ipm_mapping::kernels
